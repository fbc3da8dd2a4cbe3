"""The way from a triangulated surface to points, exact on each of a few triangles nearby."""

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]

CANDIDATES = 4
"""Sample points of the surface whose triangles are tried for each query."""


class NearestPoint:
    """Nearest points of one surface: a k-d tree finds candidate triangles, then geometry decides.

    Parameters
    ----------
    surface : Surface
        Any surface; its `samples` are put into the tree.
    """

    def __init__(self, surface: Surface) -> None:
        self._corners = surface.corners
        self._tree = scipy.spatial.KDTree(surface.samples)
        self._candidates = min(CANDIDATES, len(surface.samples))

    def vectors_to(self, queries: Array) -> Array:
        """Return the vector to each point from the nearest one of the surface, m, shape (q, 3).

        Parameters
        ----------
        queries : (q, 3) array of float
            Points, m.
        """
        return self.feet_of(queries)[0]

    def feet_of(self, queries: Array) -> tuple[Array, NDArray[np.int64]]:
        """Return `vectors_to` some points, (q, 3), and the triangles that they come from, (q,)."""
        _, samples = self._tree.query(queries, k=self._candidates)
        triangles = samples.reshape(len(queries), -1) // 3  # three samples each, in their order
        away = vectors_from_triangles(queries[:, None], self._corners[triangles])
        nearest = _dot(away, away).argmin(axis=1)
        vectors = np.take_along_axis(away, nearest[:, None, None], axis=1)[:, 0]
        return vectors, np.take_along_axis(triangles, nearest[:, None], axis=1)[:, 0]

    def shares_of(self, feet: Array, triangles: NDArray[np.int64]) -> Array:
        """Return the barycentric coordinates of points in their triangles, shape (q, 3)."""
        a, b, c = np.moveaxis(self._corners[triangles], 1, 0)
        normal = np.cross(b - a, c - a)
        parts = [np.cross(c - b, feet - b), np.cross(a - c, feet - c), np.cross(b - a, feet - a)]
        shares = [_dot(part, normal) for part in parts]
        return np.stack(shares, axis=-1) / _dot(normal, normal)[:, None]


def distance_to_triangles(points: Array, corners: Array) -> Array:
    """Return the distance of each point from its triangle, m; see `vectors_from_triangles`."""
    away = vectors_from_triangles(points, corners)
    return np.sqrt(_dot(away, away))


def vectors_from_triangles(points: Array, corners: Array) -> Array:
    """Return the vector to each point from the nearest one of its triangle, m, shape (..., 3).

    It is the perpendicular if its foot lies inside, and that of the nearest edge elsewhere.

    Parameters
    ----------
    points : (..., 3) array of float
        Points, m.
    corners : (..., 3, 3) array of float
        Triangle of each point: corner, xyz, m. Not degenerate.
    """
    a, b, c = np.moveaxis(corners, -2, 0)
    normal = np.cross(b - a, c - a)
    sides = [(a, b), (b, c), (c, a)]
    inside = np.all(
        [_dot(np.cross(normal, end - start), points - start) >= 0 for start, end in sides], axis=0
    )
    from_plane = normal * (_dot(normal, points - a) / _dot(normal, normal))[..., None]
    from_edges = np.array([_away_from_segment(points, *side) for side in sides])
    nearest = _dot(from_edges, from_edges).argmin(axis=0)
    from_edge = np.take_along_axis(from_edges, nearest[None, ..., None], axis=0)[0]
    return np.where(inside[..., None], from_plane, from_edge)


def _away_from_segment(points: Array, start: Array, end: Array) -> Array:
    along = end - start
    fraction = np.clip(_dot(points - start, along) / _dot(along, along), 0, 1)
    return points - start - fraction[..., None] * along


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i", a, b)
