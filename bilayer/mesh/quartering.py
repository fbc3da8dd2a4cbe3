"""A finer mesh of the same sheet: each triangle in four, by the middles of its edges."""

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh


def quartered(mesh: PlanarMesh) -> PlanarMesh:
    """Return the mesh with each triangle cut into four, its nodes first, in their order.

    Examples
    --------
    >>> from bilayer import PlanarMesh
    >>> points = np.array([[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]])
    >>> mesh = PlanarMesh(points, np.array([[0, 1, 2], [0, 2, 3]]), np.array([1, 1]))
    >>> fine = quartered(mesh)
    >>> len(fine.triangles), len(fine.points), float(fine.areas.sum()) == float(mesh.areas.sum())
    (8, 9, True)
    """
    a, b, c = mesh.triangles.T
    middles = mesh.points[mesh.edges].mean(axis=1)
    ab, bc, ca = (_middles(mesh, start, end) for start, end in ((a, b), (b, c), (c, a)))
    corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return PlanarMesh(
        np.concatenate([mesh.points, middles]),
        np.concatenate([np.stack(each, axis=1) for each in corners]),
        np.tile(mesh.region, len(corners)),
        mesh.layer_sets,
    )


def _middles(
    mesh: PlanarMesh, start: NDArray[np.int64], end: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return the new nodes in the middles of edges, which lie in ascending order."""
    count = len(mesh.points)
    keys = mesh.edges @ (count, 1)
    low, high = np.minimum(start, end), np.maximum(start, end)
    return count + np.searchsorted(keys, low * count + high)
