"""The discrete shell in NumPy and SciPy: the solver "dshell"."""

from dshell.settings import HingeSettings, MorleySettings, PaperSettings
from dshell.solver import SOLVER

__all__ = ["SOLVER", "HingeSettings", "MorleySettings", "PaperSettings"]
