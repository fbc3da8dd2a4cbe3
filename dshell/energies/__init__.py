"""The elastic energies of the shell and their sum."""
