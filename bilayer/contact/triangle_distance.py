"""Distance between triangles in space, pair by pair; zero where two of them cross.

Disjoint triangles are nearest at a corner of one of them or between two edges. Crossing ones have
an edge of one that pierces the other.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.nearest_point import distance_to_triangles

Array = NDArray[np.float64]


def triangle_distance(first: Array, second: Array) -> Array:
    """Return the distance of each pair of triangles, m; round-off where they cross.

    Parameters
    ----------
    first, second : (k, 3, 3) array of float
        Corners of either triangle of each pair: pair, corner, xyz, m. Not degenerate.

    Returns
    -------
    (k,) array of float
        The same with the triangles of a pair exchanged.
    """
    candidates = [
        distance_to_triangles(first, second[:, None]),
        distance_to_triangles(second, first[:, None]),
        distance_to_triangles(_plane_points(first, second), second[:, None]),
        distance_to_triangles(_plane_points(second, first), first[:, None]),
        _between_edges(first, second),
    ]
    return np.concatenate(candidates, axis=1).min(axis=1)


def _plane_points(edges_of: Array, plane_of: Array) -> Array:
    """Return the point of each edge that is nearest to the other triangle's plane, (k, 3, 3)."""
    start, end = edges_of, np.roll(edges_of, -1, axis=1)
    a, b, c = np.moveaxis(plane_of, 1, 0)
    normal = np.cross(b - a, c - a)[:, None]
    above, along = _dot(normal, start - a[:, None]), _dot(normal, end - start)
    fraction = np.divide(-above, along, out=np.zeros_like(above), where=along != 0)
    return start + np.clip(fraction, 0, 1)[..., None] * (end - start)


def _between_edges(first: Array, second: Array) -> Array:
    """Return the distance of each two edges, (k, 9); infinite if a corner is nearer.

    The common perpendicular of two lines, if its feet lie within both edges (Ericson, Real-Time
    Collision Detection, 2005, section 5.1.9).
    """
    p, q = first[:, :, None], second[:, None]
    u, v = (np.roll(triangle, -1, axis=1) - triangle for triangle in (first, second))
    u, v, apart = u[:, :, None], v[:, None], p - q
    uu, uv, vv = _dot(u, u), _dot(u, v), _dot(v, v)
    determinant = uu * vv - uv**2
    with np.errstate(divide="ignore", invalid="ignore"):  # parallel edges: a corner is as near
        s = (uv * _dot(v, apart) - vv * _dot(u, apart)) / determinant
        t = (uu * _dot(v, apart) - uv * _dot(u, apart)) / determinant
        away = apart + s[..., None] * u - t[..., None] * v
        within = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
        distance = np.where(within, np.sqrt(_dot(away, away)), np.inf)
    return distance.reshape(len(first), 9)


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("...i,...i", a, b)
