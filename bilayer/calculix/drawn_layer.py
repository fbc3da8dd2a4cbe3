"""A layer drawn in its own natural state, as quadratic wedges and hexahedra.

A program that knows no natural state other than the mesh itself is given each layer as it would
lie there alone, free of stress: scaled from the bonded flat state by its law's `natural_scale`. The
layers then no longer fit each other, and displacements that make them fit again are the prestretch.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.calculix.quadratic_mesh import Cells, QuadraticMesh
from bilayer.specimen.layer import BondedLayer
from bilayer.specimen.two_layers import TWO_LAYERS

INTERFACE, MIDDLE, OUTSIDE = 0, 1, 2


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """One layer of solid elements through its thickness.

    Parameters
    ----------
    points : (k, 3) array of float
        Nodes in the natural state, m.
    node_at : (3, p) array of int
        Node over each point of the quadratic mesh at the interface, in the middle (over vertices
        alone) and outside; -1 if there is none.
    wedges, hexahedra : (w, 15) and (h, 20) arrays of int
        Nodes of each element in the order of Abaqus: corners of the bottom, of the top, then the
        midpoints of the bottom's edges, the top's, and the upright ones.
    """

    points: NDArray[np.float64]
    node_at: NDArray[np.int64]
    wedges: Cells
    hexahedra: Cells


def draw_layer(
    mesh: QuadraticMesh, bonded: BondedLayer, scale: tuple[float, float, float]
) -> DrawnLayer:
    """Extrude the cells that a layer covers and scale them to the natural state.

    Parameters
    ----------
    mesh : QuadraticMesh
        The cells.
    bonded : BondedLayer
        Where the layer lies in the bonded flat state.
    scale : (float, float, float)
        Natural lengths over bonded ones along x, y and z.

    Returns
    -------
    DrawnLayer
        Its first nodes are those of the vertices at the interface, in the planar mesh's order.
    """
    regions = [region for region, there in enumerate(TWO_LAYERS) if bonded.name in there]
    kinds = zip(*(mesh.cells[region] for region in regions), strict=True)
    flat = [np.concatenate(cells) for cells in kinds]
    on_layer = np.zeros((3, len(mesh.points)), dtype=bool)
    for cells in flat:
        on_layer[:, cells] = True
    on_layer[MIDDLE, mesh.vertices :] = False
    node_at = np.full(on_layer.shape, -1)
    node_at[on_layer] = np.arange(on_layer.sum())
    level, place = np.nonzero(on_layer)
    outside = bonded.top if bonded.is_above else bonded.bottom
    z = np.array([0.0, outside / 2, outside])[level]
    points = np.column_stack([mesh.points[place], z]) * scale
    bottom, top = (INTERFACE, OUTSIDE) if bonded.is_above else (OUTSIDE, INTERFACE)
    wedges, hexahedra = (
        _extruded(cells, node_at[bottom], node_at[top], node_at[MIDDLE]) for cells in flat
    )
    return DrawnLayer(points, node_at, wedges, hexahedra)


def _extruded(
    cells: Cells, bottom: NDArray[np.int64], top: NDArray[np.int64], middle: NDArray[np.int64]
) -> Cells:
    corners, midpoints = np.hsplit(cells, 2)
    return np.hstack(
        [bottom[corners], top[corners], bottom[midpoints], top[midpoints], middle[corners]]
    )
