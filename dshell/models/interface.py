"""From the shell's own surface, such as the substrate's mid-plane, to the bonded interface."""

import numpy as np
from numpy.typing import NDArray

from dshell.energies.topology import sum_at_nodes

Array = NDArray[np.float64]


def bonded_interface(
    position: Array, triangles: NDArray[np.int64], flat_areas: Array, height: Array | float
) -> Array:
    """Return the bonded interface over a deformed surface.

    Each node moves along the area-weighted upward normal of its triangles. What lies between keeps
    its volume, so the way is that of the flat bonded state divided by the area stretch of those
    triangles.

    Parameters
    ----------
    position : (n, 3) array of float
        The surface, m.
    triangles : (m, 3) array of int
        Counterclockwise seen from above.
    flat_areas : (m,) array of float
        Areas in the flat bonded state, m2.
    height : float or (n,) array of float
        Of the bond above the surface in the flat bonded state, m: half the substrate's thickness
        over its mid-plane, or, where the substrate is the upper layer, under it.
    """
    a, b, c = np.moveaxis(position[triangles], 1, 0)
    area_vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(area_vectors, axis=1)
    around = [sum_at_nodes(triangles, column) for column in area_vectors.T]
    normals = np.column_stack(around) / np.linalg.norm(around, axis=0)[:, None]
    stretch = sum_at_nodes(triangles, areas) / sum_at_nodes(triangles, flat_areas)
    return position + (height / stretch)[:, None] * normals
