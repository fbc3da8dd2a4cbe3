"""Strains, stresses, energies and curvatures of released shapes, the same from all solvers."""
