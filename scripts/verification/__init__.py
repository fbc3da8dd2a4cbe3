"""The verification ladder: cases with known answers, what the solvers make of them, the table."""
