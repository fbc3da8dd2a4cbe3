"""CalculiX, the independent finite-element program: decks out, shapes back."""
