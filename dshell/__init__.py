"""The discrete shell in NumPy and SciPy: the solver "dshell"."""

from dshell.settings import HingeSettings, MorleySettings, PaperSettings
from dshell.solver import BYTES_PER_TRIANGLE, DEFAULT_START, MODELS, PARALLEL, solve

__all__ = [
    "BYTES_PER_TRIANGLE",
    "DEFAULT_START",
    "MODELS",
    "PARALLEL",
    "HingeSettings",
    "MorleySettings",
    "PaperSettings",
    "solve",
]
