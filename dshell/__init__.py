"""The discrete shell in NumPy and SciPy; the package that `bilayer.solvers` calls "dshell"."""

from dshell.settings import MorleySettings, PaperSettings
from dshell.solver import BYTES_PER_TRIANGLE, MODELS, PARALLEL, solve

__all__ = [
    "BYTES_PER_TRIANGLE",
    "MODELS",
    "PARALLEL",
    "MorleySettings",
    "PaperSettings",
    "solve",
]
