"""From the shell's own surface, such as the substrate's mid-plane, to the reference surface.

That is the surface whose place a result tells: see `Specimen.reference_surface`.
"""

import numpy as np
from numpy.typing import NDArray

from dshell.energies.topology import sum_at_nodes

Array = NDArray[np.float64]


def reference_surface_over(
    position: Array, triangles: NDArray[np.int64], flat_areas: Array, height: Array | float
) -> Array:
    """Return the reference surface over a deformed surface.

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
        Of the reference surface above the other in the flat bonded state, m: for the bond half
        the substrate's thickness over its mid-plane or, if the substrate is the upper layer,
        under it.
    """
    a, b, c = np.moveaxis(position[triangles], 1, 0)
    area_vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(area_vectors, axis=1)
    around = [sum_at_nodes(triangles, column) for column in area_vectors.T]
    normals = np.column_stack(around) / np.linalg.norm(around, axis=0)[:, None]
    stretch = sum_at_nodes(triangles, areas) / sum_at_nodes(triangles, flat_areas)
    return position + (height / stretch)[:, None] * normals


def reference_surface_gradient(
    position: Array,
    triangles: NDArray[np.int64],
    flat_areas: Array,
    height: Array | float,
    gradient: Array,
) -> Array:
    """Return the gradient by a surface, given that by the reference surface over it.

    Parameters
    ----------
    position, triangles, flat_areas, height
        As those of `reference_surface_over`.
    gradient : (n, 3) array of float
        Derivative of a number by the reference surface.

    Returns
    -------
    (n, 3) array of float
        Its derivative by the surface below.
    """
    a, b, c = np.moveaxis(position[triangles], 1, 0)
    area_vectors = 0.5 * np.cross(b - a, c - a)
    areas = np.linalg.norm(area_vectors, axis=1)
    around = np.column_stack([sum_at_nodes(triangles, column) for column in area_vectors.T])
    length = np.linalg.norm(around, axis=1)
    normals = around / length[:, None]
    flat_around = sum_at_nodes(triangles, flat_areas)
    stretch = sum_at_nodes(triangles, areas) / flat_around
    along = np.sum(gradient * normals, axis=1)
    by_around = (height / stretch / length)[:, None] * (gradient - along[:, None] * normals)
    by_area = -height / stretch**2 * along / flat_around
    by_vectors = by_around[triangles].sum(axis=1)
    by_vectors += (by_area[triangles].sum(axis=1) / areas)[:, None] * area_vectors
    by_b, by_c = 0.5 * np.cross(c - a, by_vectors), 0.5 * np.cross(by_vectors, b - a)
    total = gradient.copy()
    for corner, part in enumerate((-by_b - by_c, by_b, by_c)):
        np.add.at(total, triangles[:, corner], part)
    return total


def reference_surface_flat_gradient(
    position: Array,
    triangles: NDArray[np.int64],
    flat_points: Array,
    height: Array | float,
    gradient: Array,
) -> Array:
    """Return the gradient by the flat places of the nodes, the surface below being fixed.

    They are in the reference surface by the area stretch alone.

    Parameters
    ----------
    position, triangles, height, gradient
        As those of `reference_surface_gradient`.
    flat_points : (n, 2) array of float
        The flat places, m.
    """
    a, b, c = np.moveaxis(position[triangles], 1, 0)
    area_vectors = 0.5 * np.cross(b - a, c - a)
    around = np.column_stack([sum_at_nodes(triangles, column) for column in area_vectors.T])
    normals = around / np.linalg.norm(around, axis=1)[:, None]
    areas = sum_at_nodes(triangles, np.linalg.norm(area_vectors, axis=1))
    by_flat_area = (height / areas * np.sum(gradient * normals, axis=1))[triangles].sum(axis=1)
    x, y = np.moveaxis(flat_points[triangles], 2, 0)
    total = np.zeros_like(flat_points)
    for corner in range(3):
        ahead, behind = (corner + 1) % 3, (corner + 2) % 3
        by_corner = np.column_stack([y[:, ahead] - y[:, behind], x[:, behind] - x[:, ahead]])
        np.add.at(total, triangles[:, corner], 0.5 * by_flat_area[:, None] * by_corner)
    return total
