"""The verbs of the command line, a module each: `add` its arguments, `run` it."""

from bilayer.verbs import compare, convert, export, import_, info, init, mesh, plot, solve, study

VERBS = (init, mesh, solve, compare, plot, convert, export, import_, info, study)

__all__ = ["VERBS"]
