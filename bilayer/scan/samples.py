"""Points that lie evenly on a surface, with its normals."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Samples:
    """Points of a surface.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        m.
    normals : ndarray, shape (n, 3)
        Unit normals of their triangles.
    spacing : float
        About the distance between neighbours, m.
    diagonal : float
        Of the box around the surface, m.
    """

    points: Array
    normals: Array
    spacing: float
    diagonal: float

    @cached_property
    def size(self) -> float:
        """Largest extent along an axis, m."""
        return float(np.ptp(self.points, axis=0).max())

    @cached_property
    def tree(self) -> Any:
        """For the nearest of them."""
        from scipy.spatial import cKDTree  # slow to load

        return cKDTree(self.points)

    def thinned(self, count: int) -> "Samples":
        """Return about so many of them, which lie as evenly."""
        step = max(1, len(self.points) // count)
        few = slice(None, None, step)
        spacing = self.spacing * math.sqrt(step)
        return Samples(self.points[few], self.normals[few], spacing, self.diagonal)

    def nearest(self, points: Array) -> "Nearest":
        """Return where points lie, seen from the nearest samples.

        Parameters
        ----------
        points : ndarray, shape (m, 3)
            m.
        """
        apart, sample = self.tree.query(points)
        along = np.sum((points - self.points[sample]) * self.normals[sample], axis=1)
        aside = np.sqrt(np.maximum(apart**2 - along**2, 0.0))
        beyond = aside > 2 * self.spacing
        return Nearest(sample, np.where(beyond, np.copysign(apart, along), along), beyond)


class Nearest(NamedTuple):
    """Where points lie, seen from the nearest samples of a surface.

    Parameters
    ----------
    sample : ndarray of int, shape (m,)
        Number of the nearest one.
    distance : ndarray, shape (m,)
        From the plane of its triangle, m; beyond the rim from the sample itself. Positive on the
        upper side.
    is_beyond : ndarray of bool, shape (m,)
        Whether a point lies beyond the rim.
    """

    sample: NDArray[np.int64]
    distance: Array
    is_beyond: NDArray[np.bool_]


def at_most(count: int, points: Array) -> Array:
    """Return at most so many points, drawn at random, always the same."""
    if len(points) <= count:
        return points
    return points[np.random.default_rng(0).choice(len(points), count, replace=False)]


def even_samples(surface: Surface, count: int) -> Samples:
    """Return about so many points, as many on each triangle as its area asks for.

    They follow the sequence R2 of low discrepancy (Roberts 2018), folded onto the triangle, so the
    same surface gives the same points.

    Parameters
    ----------
    surface : Surface
        m.
    count : int
        How many.
    """
    areas = surface.areas
    shares = np.cumsum(areas) / areas.sum() * count
    ends = np.rint(shares).astype(np.int64)
    number = np.diff(ends, prepend=0)
    face = np.repeat(np.arange(len(areas)), number)
    k = np.arange(len(face)) + 0.5
    golden = 1.32471795724474602596
    a, b = (k / golden) % 1.0, (k / golden**2) % 1.0
    outside = a + b > 1
    a, b = np.where(outside, 1 - a, a), np.where(outside, 1 - b, b)
    corners = surface.corners[face]
    points = corners[:, 0] + a[:, None] * (corners[:, 1] - corners[:, 0])
    points += b[:, None] * (corners[:, 2] - corners[:, 0])
    with np.errstate(invalid="ignore", divide="ignore"):
        normals = (surface.area_vectors / areas[:, None])[face]
    spacing = float(np.sqrt(areas.sum() / max(len(face), 1)))
    diagonal = float(np.linalg.norm(np.ptp(surface.points, axis=0)))
    return Samples(points, normals, spacing, diagonal)
