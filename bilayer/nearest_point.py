"""Distance from points to a triangulated surface, exact on each of a few triangles nearby."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from bilayer.surface import Surface

Array = NDArray[np.float64]

CANDIDATES = 4
"""Sample points of the surface whose triangles are tried for each query."""


class NearestPoint:
    """Distances to one surface: a k-d tree finds candidate triangles, then geometry decides.

    Parameters
    ----------
    surface : Surface
        Any surface; its `samples` are put into the tree.
    """

    def __init__(self, surface: Surface) -> None:
        self._corners = surface.corners
        self._tree = KDTree(surface.samples)
        self._candidates = min(CANDIDATES, len(surface.samples))

    def distance(self, queries: Array) -> Array:
        """Return the distance of each point from the surface, m.

        Parameters
        ----------
        queries : (q, 3) array of float
            Points, m.
        """
        _, samples = self._tree.query(queries, k=self._candidates)
        triangles = samples.reshape(len(queries), -1) // 3  # three samples each, in their order
        return distance_to_triangles(queries[:, None], self._corners[triangles]).min(axis=1)


def distance_to_triangles(points: Array, corners: Array) -> Array:
    """Return the distance of each point from its triangle.

    It is the distance from the plane where the foot of the perpendicular lies inside, and that
    from the nearest edge elsewhere.

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
    from_plane = np.abs(_dot(normal, points - a)) / np.sqrt(_dot(normal, normal))
    from_edges = np.min([_distance_to_segment(points, *side) for side in sides], axis=0)
    return np.where(inside, from_plane, from_edges)


def _distance_to_segment(points: Array, start: Array, end: Array) -> Array:
    along = end - start
    fraction = np.clip(_dot(points - start, along) / _dot(along, along), 0, 1)
    away = points - start - fraction[..., None] * along
    return np.sqrt(_dot(away, away))


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i", a, b)
