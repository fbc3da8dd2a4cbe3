"""From the shell's reference surface, the substrate's mid-plane, to the bonded interface."""

import numpy as np
from numpy.typing import NDArray

from dshell.topology import sum_at_nodes

Array = NDArray[np.float64]


def bonded_interface(
    position: Array, triangles: NDArray[np.int64], flat_areas: Array, thickness: float
) -> Array:
    """Return the bonded interface over a deformed substrate mid-plane.

    Each node moves by half the substrate's thickness along the area-weighted normal of its
    triangles, toward the kirigami layer; the substrate keeps its volume, so its thickness is the
    flat bonded one divided by the area stretch of those triangles.

    Parameters
    ----------
    position : (n, 3) array of float
        The substrate's mid-plane, m.
    triangles : (m, 3) array of int
        Counterclockwise seen from the kirigami layer.
    flat_areas : (m,) array of float
        Areas in the flat bonded state, m2.
    thickness : float
        Thickness of the flat bonded substrate, m.
    """
    a, b, c = np.moveaxis(position[triangles], 1, 0)
    area_vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(area_vectors, axis=1)
    around = [sum_at_nodes(triangles, column) for column in area_vectors.T]
    normals = np.column_stack(around) / np.linalg.norm(around, axis=0)[:, None]
    stretch = sum_at_nodes(triangles, areas) / sum_at_nodes(triangles, flat_areas)
    return position + (thickness / 2 / stretch)[:, None] * normals
