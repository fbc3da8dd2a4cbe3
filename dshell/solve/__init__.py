"""Newton's method, dynamics and the linear solvers of the shell."""
