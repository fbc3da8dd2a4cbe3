"""The planar mesh that both solvers share: generated, checked, read and written."""
