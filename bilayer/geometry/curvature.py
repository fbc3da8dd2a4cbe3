"""Normals and curvatures of a triangulated surface at its nodes, from quadratics fitted around.

Around each node the surface is a height over its tangent plane, z = a x + b y + (c x^2 + 2 d x y +
e y^2) / 2, fitted by least squares to the nodes up to two edges away. The curvatures are those of
that quadratic at the node. The error falls at least with the edge length.

Source: F. Cazals and M. Pouget, *Estimating differential quantities using polynomial fitting of
osculating jets*, Computer Aided Geometric Design 22 (2005) 121-146.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface, directed_edges

Array = NDArray[np.float64]

UNKNOWNS = 5
RINGS = 2
"""Edges up to which nodes count; more around a node that has too few."""
MOST_RINGS = 4
SMALLEST_PIVOT = 1e-9
"""Least singular value of a fit over the largest; a fit below is of nodes on a line."""


@dataclass(frozen=True, eq=False)
class Curvatures:
    """A surface's normals and curvatures at its nodes.

    Parameters
    ----------
    normal : (n, 3) array of float
        Upward unit normals.
    mean, gaussian : (n,) array of float
        Mean curvature, 1/m, positive where the surface bulges to its upper side, and Gaussian
        curvature, 1/m2. Not a number at nodes that have too few others around them.
    """

    normal: Array
    mean: Array
    gaussian: Array


def curvatures(surface: Surface) -> Curvatures:
    """Return normals and curvatures of a surface at its nodes.

    Parameters
    ----------
    surface : Surface
        Nodes without triangles have no curvature.

    Examples
    --------
    A square of four triangles on a cylinder of radius 2 about y:

    >>> import numpy as np
    >>> angle, y = np.meshgrid(np.linspace(-0.1, 0.1, 5), np.linspace(-0.2, 0.2, 5))
    >>> points = np.column_stack([2 * np.sin(angle.ravel()), y.ravel(), 2 * np.cos(angle.ravel())])
    >>> k = np.arange(20).reshape(4, 5)[:, :4].ravel()
    >>> squares = [[k, k + 1, k + 6], [k, k + 6, k + 5]]
    >>> triangles = np.concatenate([np.stack(part, axis=1) for part in squares])
    >>> found = curvatures(Surface(points, triangles))
    >>> bool(abs(found.mean[12] - 0.25) < 1e-3), bool(abs(found.gaussian[12]) < 1e-9)
    (True, True)
    """
    normal = _node_normals(surface)
    around = _neighbours(surface)
    for _ in range(2):  # the second time from the better normals
        normal, second = _fit(surface.points, normal, *around)
    c, d, e, slope_x, slope_y = second
    squared = 1 + slope_x**2 + slope_y**2
    bent = (1 + slope_y**2) * c - 2 * slope_x * slope_y * d + (1 + slope_x**2) * e
    return Curvatures(normal, -bent / (2 * squared**1.5), (c * e - d * d) / squared**2)


def _node_normals(surface: Surface) -> Array:
    """Return the directions of the area vectors around each node."""
    total = np.zeros_like(surface.points)
    for corner in range(3):
        np.add.at(total, surface.triangles[:, corner], surface.area_vectors)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(np.divide(total, length, out=np.full_like(total, np.nan), where=length > 0))


def _neighbours(surface: Surface) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Return the nodes around each node, (n, k), and which of these places are taken."""
    from scipy.sparse import csr_matrix, identity  # slow to load

    count = len(surface.points)
    pairs = directed_edges(surface.triangles)
    ends = np.concatenate([pairs, pairs[:, ::-1]])
    beside = csr_matrix((np.ones(len(ends), dtype=np.int8), ends.T), shape=(count, count))
    step = (beside + identity(count, dtype=np.int8, format="csr")).astype(bool)
    rings = [step]
    for _ in range(MOST_RINGS - 1):
        rings.append((rings[-1] @ step).astype(bool))
    near = rings[RINGS - 1].tolil()
    for wider in rings[RINGS:]:
        few = np.flatnonzero(np.asarray(near.sum(axis=1)).ravel() < UNKNOWNS + 3)
        if len(few) == 0:
            break
        near[few] = wider[few]
    found = near.tocsr()
    found.setdiag(False)
    found.eliminate_zeros()
    found.sort_indices()
    size = np.diff(found.indptr)
    place = np.arange(max(1, size.max()))
    taken = place < size[:, None]
    nodes = np.zeros(taken.shape, dtype=np.int64)
    nodes[taken] = found.indices
    return nodes, taken


def _fit(
    points: Array, normal: Array, nodes: NDArray[np.int64], taken: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """Return better normals, and (c, d, e, a, b) at each node, (5, n)."""
    first, other = _tangents(normal)
    away = points[nodes] - points[:, None]
    x, y, z = (np.einsum("nki,ni->nk", away, axis) for axis in (first, other, normal))
    size = np.sqrt(np.max(np.where(taken, x * x + y * y, 0.0), axis=1, initial=0.0))
    known = (taken.sum(axis=1) >= UNKNOWNS) & (size > 0) & np.isfinite(normal).all(axis=1)
    scale = np.where(known, size, 1.0)[:, None]
    x, y, z = x / scale, y / scale, z / scale
    terms = np.stack([x * x / 2, x * y, y * y / 2, x, y], axis=2) * taken[:, :, None]
    solved = np.full((len(points), UNKNOWNS), np.nan)
    inverse = np.linalg.pinv(terms[known], rcond=SMALLEST_PIVOT)
    solved[known] = np.einsum("nik,nk->ni", inverse, (z * taken)[known])
    solved[:, :3] /= scale
    a, b = np.nan_to_num(solved[:, 3:].T)
    tilted = normal - a[:, None] * first - b[:, None] * other
    return tilted / np.linalg.norm(tilted, axis=1, keepdims=True), solved.T


def _tangents(normal: Array) -> tuple[Array, Array]:
    """Return two unit vectors, right-handed with each normal."""
    axis = np.zeros_like(normal)
    axis[np.arange(len(normal)), np.argmin(np.abs(np.nan_to_num(normal)), axis=1)] = 1.0
    first: Array = np.asarray(np.cross(axis, normal), dtype=np.float64)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.asarray(np.cross(normal, first), dtype=np.float64)
