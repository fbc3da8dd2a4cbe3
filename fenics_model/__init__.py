"""The 3D finite-element model of a sheet: mixed displacement-pressure, hyperelastic, released."""

from fenics_model.settings import SolidSettings
from fenics_model.solver import SOLVER

__all__ = ["SOLVER", "SolidSettings"]
