"""The shape of a result at the nodes of another planar mesh: the same places of the flat sheet.

The shape is interpolated over the flat sheet by cubics with continuous slopes (Clough and Tocher),
and beyond its nodes, as between a chord and the rim, by quadratics through the nearest ones. The
error falls as the square of its edge length or faster; it is part of a distance between results on
two meshes.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh

Array = NDArray[np.float64]

AROUND = 14
"""Nodes through which a quadratic is laid beyond the rim."""


def positions_on(target: PlanarMesh, source: PlanarMesh, positions: Array) -> Array:
    """Return shapes at the nodes of another mesh of the same sheet.

    Parameters
    ----------
    target : PlanarMesh
        Where they are wanted, n nodes.
    source : PlanarMesh
        Where they are known, m nodes.
    positions : (k, m, 3) array of float
        The shapes, m; not a number where one is not known.

    Returns
    -------
    (k, n, 3) array of float
        The same array if the meshes are the same.
    """
    if target.same_as(source):
        return positions
    from scipy.interpolate import CloughTocher2DInterpolator  # slow to load
    from scipy.spatial import Delaunay

    scale = np.abs(source.points).max()
    flat, wanted = source.points / scale, target.points / scale
    cells, found = Delaunay(flat), np.full((len(positions), len(wanted), 3), np.nan)
    for row, shape in zip(found, positions, strict=True):
        if np.isfinite(shape).all():
            row[:] = CloughTocher2DInterpolator(cells, shape)(wanted)
            outside = np.flatnonzero(np.isnan(row[:, 0]))
            beyond: Array = np.take(wanted, outside, axis=0)
            row[outside] = _extended(flat, np.asarray(shape), beyond)
    return found


def _extended(flat: Array, shape: Array, wanted: Array) -> Array:
    """Return places on quadratics through the nearest nodes, (q, 3)."""
    from scipy.spatial import cKDTree

    nearest = cKDTree(flat).query(wanted, k=min(AROUND, len(flat)))[1].reshape(len(wanted), -1)
    away = flat[nearest] - wanted[:, None]
    x, y = np.moveaxis(away / np.abs(away).max(axis=(1, 2), keepdims=True), 2, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    return np.asarray((np.linalg.pinv(terms) @ shape[nearest])[:, 0])
