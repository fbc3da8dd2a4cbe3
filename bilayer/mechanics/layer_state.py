"""The deformation of one layer, as a solver hands it over: the fields follow from it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.mechanics.memory import ELASTIC, Memory

Array = NDArray[np.float64]

LEVELS = ("bottom", "middle", "top")
"""The heights in a layer at which strain and stress are told: its faces and its middle."""


@dataclass(frozen=True, eq=False)
class LayerState:
    """One layer of a body in equilibrium, on the k triangles of the planar mesh that it covers.

    Parameters
    ----------
    name : str
        Of the layer.
    faces : (k,) array of int
        Triangles of the planar mesh, ascending.
    stretch : (3, k, 3, 3) array of float
        Right Cauchy-Green tensor C = F^T F at the heights `LEVELS`, over the centroid of each
        triangle. F leads from the natural state, whose axes are x and y of the flat sheet and z
        across it.
    rotation : (3, k, 3, 3) array of float
        R in F = R U, from the axes of the flat sheet to those of `position`.
    pressure : (3, k) array of float or None
        Mean of the three principal Cauchy stresses, Pa, if it is an unknown of its own; None: the
        stress across the layer vanishes.
    energy : (k,) array of float
        Of all that lies over each triangle, J.
    volume : (k,) array of float
        Natural volume of that, m3.
    memory : Memory
        Of a layer that relaxes: its pull, (3, k, 3, 3), is the dead stress of the change of shape,
        second Piola-Kirchhoff with the flat bonded state as reference, per natural volume; see
        `bilayer.mechanics.stress.cauchy_stress`.
    """

    name: str
    faces: NDArray[np.int64]
    stretch: Array
    rotation: Array
    pressure: Array | None
    energy: Array
    volume: Array
    memory: Memory = ELASTIC


def polar_rotation(gradient: Array) -> Array:
    """Return the rotation R in F = R U of gradients (..., 3, 3)."""
    left, _, right = np.linalg.svd(gradient)
    return np.asarray(left @ right)
