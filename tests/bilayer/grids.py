"""Meshes of squares cut in halves, of any outline that squares make, without a mesh generator."""

import numpy as np

from bilayer import PlanarMesh


def grid_mesh(cells, size=1.0, origin=(0.0, 0.0)):
    """Return the mesh of some unit cells, two triangles each, all of them bare.

    Parameters
    ----------
    cells : sequence of (int, int)
        Column and row of each.
    size : float
        Of a cell, m.
    origin : (float, float)
        Of the corner of the cell (0, 0), m.
    """
    corners = np.array([[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]])
    places = np.concatenate([corners + cell for cell in cells]).reshape(-1, 2)
    points, triangles = np.unique(places, axis=0, return_inverse=True)
    triangles = triangles.reshape(-1, 3)
    return PlanarMesh(np.add(origin, size * points), triangles, np.zeros(len(triangles), dtype=int))


def rectangle(columns, rows):
    """Return the cells of a rectangle."""
    return [(x, y) for x in range(columns) for y in range(rows)]


def frame(columns, rows):
    """Return the cells of a rectangle without those inside, one cell wide."""
    inner = {(x + 1, y + 1) for x, y in rectangle(columns - 2, rows - 2)}
    return [cell for cell in rectangle(columns, rows) if cell not in inner]
