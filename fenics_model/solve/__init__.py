"""Newton's method by PETSc, and what it costs."""
