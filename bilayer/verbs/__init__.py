"""The verbs of the command line, a module each: `add` its arguments, `run` it."""

from bilayer.verbs import compare, convert, info, init, mesh, plot, solve

VERBS = (init, mesh, solve, compare, plot, convert, info)

__all__ = ["VERBS"]
