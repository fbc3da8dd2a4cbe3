"""The solvers by name, what they have in common, and a result computed again."""
