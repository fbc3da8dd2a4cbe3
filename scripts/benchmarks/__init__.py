"""What the solvers cost: a module per benchmark, and what they share."""
