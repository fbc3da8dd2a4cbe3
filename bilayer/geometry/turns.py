"""The angles by which a surface of flat triangles turns over its edges."""

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface


def turns_over_edges(surface: Surface) -> NDArray[np.float64]:
    """Return the angle between the triangles on either side of each inner edge.

    Parameters
    ----------
    surface : Surface
        Each of its edges belongs to one triangle or to two.

    Returns
    -------
    (e,) array of float
        0 to pi, rad; 0 over an edge that is not bent.

    Examples
    --------
    Two triangles of a cube, which meet in one of its edges:

    >>> import numpy as np
    >>> points = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [0, 0, 1]])
    >>> roof = Surface(points, np.array([[0, 2, 1], [0, 1, 3]]))
    >>> float(np.degrees(turns_over_edges(roof)).round(9).item())
    90.0
    """
    first, second = _neighbours(surface.triangles)
    normals = surface.area_vectors
    sines = np.linalg.norm(np.cross(normals[first], normals[second]), axis=1)
    return np.arctan2(sines, (normals[first] * normals[second]).sum(axis=1))


def _neighbours(triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the triangles on either side of each inner edge."""
    pairs = np.sort(np.concatenate([np.roll(triangles, -k, axis=1)[:, :2] for k in range(3)]))
    faces = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort(pairs.T)
    shared = np.flatnonzero((pairs[order][1:] == pairs[order][:-1]).all(axis=1))
    return faces[order][shared], faces[order][shared + 1]
