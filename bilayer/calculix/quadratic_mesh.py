"""The planar mesh as quadratic cells: six-node triangles and eight-node quadrilaterals.

Quadrilaterals are pairs of neighbouring triangles, so that every node of the planar mesh stays a
node and results can be brought back to it; triangles that find no partner remain. Edges are
straight, their midpoints are nodes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.calculix.triangle_pairing import pair_triangles
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.two_layers import BARE, KIRIGAMI
from bilayer.validation import one_of

Cells = NDArray[np.int64]
ELEMENTS = ("hexahedron", "wedge")


@dataclass(frozen=True, eq=False)
class QuadraticMesh:
    """Quadratic cells on a planar mesh.

    Parameters
    ----------
    points : (p, 2) array of float
        The nodes of the planar mesh in their order, then the midpoints of edges, m.
    vertices : int
        Number of nodes of the planar mesh.
    cells : mapping of int to tuple of (m, k) arrays of int
        By region (`BARE`, `KIRIGAMI`): triangles (k = 6) and quadrilaterals (k = 8), corners
        counterclockwise, then the midpoints of the edges that start at each corner.
    """

    points: NDArray[np.float64]
    vertices: int
    cells: dict[int, tuple[Cells, Cells]]


def quadratic_mesh(mesh: PlanarMesh, element: str = "hexahedron") -> QuadraticMesh:
    """Return the quadratic cells whose extrusion gives one kind of element.

    Parameters
    ----------
    mesh : PlanarMesh
        The planar mesh.
    element : {"hexahedron", "wedge"}
        Pair triangles wherever possible, or leave all of them as they are.

    Raises
    ------
    InputError
        The element is unknown.
    ComputationError
        gmsh, which pairs the triangles, is not there or fails.
    """
    if one_of("element", element, ELEMENTS) == "hexahedron":
        corners = pair_triangles(mesh)
    else:
        corners = {region: (mesh.triangles[mesh.region == region], np.empty((0, 4), np.int64))
                   for region in (BARE, KIRIGAMI)}  # fmt: skip
    linear = [cells for pair in corners.values() for cells in pair]
    ends = np.concatenate([_edges(cells) for cells in linear])
    edges, midpoint = np.unique(ends, axis=0, return_inverse=True)
    counts = np.cumsum([cells.size for cells in linear])[:-1]
    middles = np.split(midpoint.ravel() + len(mesh.points), counts)
    quadratic = iter(
        np.hstack([cells, middle.reshape(cells.shape)])
        for cells, middle in zip(linear, middles, strict=True)
    )
    points = np.concatenate([mesh.points, mesh.points[edges].mean(axis=1)])
    cells = {region: (next(quadratic), next(quadratic)) for region in corners}
    return QuadraticMesh(points, len(mesh.points), cells)


def _edges(cells: Cells) -> Cells:
    """Return the ends of the edge from each corner, ascending, shape (cells * corners, 2)."""
    return np.sort(np.stack([cells, np.roll(cells, -1, axis=1)], axis=2), axis=2).reshape(-1, 2)
