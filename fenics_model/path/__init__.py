"""The load path: continuation, step control, and the shapes that lead."""
