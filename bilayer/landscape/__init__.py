"""The stable shapes of a specimen at one prestretch, and what lies between them."""
