"""A triangulated surface in space: areas, normals, points that stand for it in integrals."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def directed_edges(triangles: Indices) -> Indices:
    """Return the edges along which triangles (m, 3) run, (3 m, 2): all first ones, then second."""
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface of flat triangles.

    Parameters
    ----------
    points : (n, 3) array of float
        Node coordinates, m.
    triangles : (m, 3) array of int
        Nodes of each triangle, counterclockwise as seen from the upper side.
    """

    points: Array
    triangles: NDArray[np.int64]

    @cached_property
    def corners(self) -> Array:
        """Corners of each triangle, m, shape (m, 3, 3): triangle, corner, xyz."""
        return np.take(self.points, self.triangles, axis=0)

    @cached_property
    def area_vectors(self) -> Array:
        """Upward normal of each triangle times its area, m2, shape (m, 3)."""
        a, b, c = np.moveaxis(self.corners, 1, 0)
        return 0.5 * np.cross(b - a, c - a)

    @cached_property
    def areas(self) -> Array:
        """Area of each triangle, m2, shape (m,)."""
        return np.linalg.norm(self.area_vectors, axis=1)

    @cached_property
    def node_areas(self) -> Array:
        """Lumped areas: a third of the triangles around each node, m2, shape (n,)."""
        thirds = np.repeat(self.areas / 3, 3)
        lumped = np.bincount(self.triangles.ravel(), thirds, minlength=len(self.points))
        return lumped.astype(np.float64, copy=False)

    @cached_property
    def centroid(self) -> Array:
        """Centre of area, m, shape (3,)."""
        return np.average(self.corners.mean(axis=1), axis=0, weights=self.areas)

    @cached_property
    def samples(self) -> Array:
        """Three points in each triangle that stand for a third of its area each, m, (3 m, 3).

        The rule of degree 2 with barycentric coordinates (2/3, 1/6, 1/6) (Strang and Fix 1973).
        """
        return (self.corners / 2 + self.corners.mean(axis=1, keepdims=True) / 2).reshape(-1, 3)

    @cached_property
    def sample_areas(self) -> Array:
        """Area that each of `samples` stands for, m2, shape (3 m,)."""
        return np.repeat(self.areas / 3, 3)
