"""The 3D finite-element model of a bilayer: mixed displacement-pressure, hyperelastic, released."""

import fenics_model.solve  # first: the function of that name, below, shall win
from fenics_model.settings import BYTES_PER_TRIANGLE, MODELS, SolidSettings
from fenics_model.solver import DEFAULT_START, PARALLEL, solve

__all__ = ["BYTES_PER_TRIANGLE", "DEFAULT_START", "MODELS", "PARALLEL", "SolidSettings", "solve"]
