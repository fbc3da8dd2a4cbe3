"""Measures of a released shape, taken in the body's own frame."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.planar_mesh import PlanarMesh


@dataclass(frozen=True)
class ShapeMeasures:
    """What is measured of one shape, in m where a length.

    `span` is the extent (x, y, z) in the body frame, `height` its z.
    """

    quality: float
    sphere_radius: float
    sphere_rmse: float
    hemisphere_distance: float
    span: NDArray[np.float64]
    height: float

    @classmethod
    def undefined(cls) -> "ShapeMeasures":
        """Return the measures of a shape that was not computed: all NaN."""
        return cls(*[math.nan] * 4, np.full(3, np.nan), math.nan)


def measure_shape(mesh: PlanarMesh, position: NDArray[np.float64]) -> ShapeMeasures:
    """Measure a shape (being written)."""
    return ShapeMeasures.undefined()
