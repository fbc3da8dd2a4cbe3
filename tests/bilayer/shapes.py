"""Maps of the flat disc on surfaces whose measures are known, for the tests of several modules."""

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def in_plane(points: Array) -> Array:
    return np.column_stack([points, np.zeros(len(points))])


def cap(points: Array, half_angle: float, radius: float = 0.04) -> Array:
    """The disc of a radius on a spherical cap, meridians keeping their length."""
    a = radius / half_angle
    along, around = np.hypot(*points.T) / a, np.arctan2(points[:, 1], points[:, 0])
    across = a * np.sin(along)
    return np.column_stack(
        [across * np.cos(around), across * np.sin(around), a * (np.cos(along) - 1)]
    )


def cylinder(points: Array, half_angle: float, radius: float = 0.04) -> Array:
    """The disc of a radius bent along x to a cylinder, to `half_angle` at its rim."""
    a = radius / half_angle
    along = points[:, 0] / a
    return np.column_stack([a * np.sin(along), points[:, 1], a * (np.cos(along) - 1)])


def cone(points: Array, half_angle: float) -> Array:
    """The disc as a cone of an opening half-angle, its generators keeping their length."""
    return np.column_stack(
        [points * math.sin(half_angle), -np.hypot(*points.T) * math.cos(half_angle)]
    )
