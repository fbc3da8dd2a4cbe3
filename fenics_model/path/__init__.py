"""The load path: continuation, step control, initial guesses from another result."""
