"""A layer drawn in its own natural state, as quadratic wedges and hexahedra.

A program that knows no natural state other than the mesh itself is given each layer as it would
lie there alone, free of stress: scaled from the bonded flat state by `natural_scale`. The layers
then no longer fit each other, and displacements that make them fit again are the prestretch.
"""

import math
from dataclasses import dataclass
from functools import singledispatch

import numpy as np
from numpy.typing import NDArray

from bilayer.calculix.quadratic_mesh import Cells, QuadraticMesh
from bilayer.errors import InputError
from bilayer.specimen.layer import BondedLayer
from bilayer.specimen.material import Law, LinearElastic, MooneyRivlin
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
        alone) and outside; -1 where there is none.
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


@singledispatch
def natural_scale(law: Law, stretch: tuple[float, float]) -> tuple[float, float, float]:
    """Return natural lengths over bonded ones along x, y, z of a layer bonded under a stretch.

    A hyperelastic layer keeps its volume when it is stretched: (1/lx, 1/ly, lx ly). The linear law
    has the energy of the strain e = E + eps0, E the Green strain from the bonded flat state. With
    A = sqrt(I - 2 eps0), e = A E' A, where E' is the Green strain from the mesh scaled by A.

    Parameters
    ----------
    law : MooneyRivlin or LinearElastic
        The layer's law.
    stretch : (float, float)
        (lambda_x, lambda_y) under which it is bonded.

    Raises
    ------
    InputError
        No stress-free state belongs to the initial strain of the linear law.
    """
    raise NotImplementedError(f"no natural state for {type(law).__name__}")


@natural_scale.register
def _(law: MooneyRivlin, stretch: tuple[float, float]) -> tuple[float, float, float]:
    x, y = stretch
    return 1 / x, 1 / y, x * y


@natural_scale.register
def _(law: LinearElastic, stretch: tuple[float, float]) -> tuple[float, float, float]:
    in_plane = stretch[0] - 1, stretch[1] - 1
    nu = law.poisson_ratio
    strains = (*in_plane, -nu / (1 - nu) * sum(in_plane))  # eq. 9 of the paper
    squares = [1 - 2 * strain for strain in strains]
    if min(squares) <= 0:
        raise InputError(
            f"prestretch.milestones = {max(stretch):g}: the linear law has no stress-free state "
            "there, expected less than 1.5"
        )
    x, y, z = (math.sqrt(square) for square in squares)
    return x, y, z
