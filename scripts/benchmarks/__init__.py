"""The cost of the solvers: a module for each benchmark, and their common parts."""
