"""Stability, and the way from an unstable equilibrium to stable ones."""
