"""Neighbouring triangles of a planar mesh joined to quadrilaterals, by gmsh."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.mesh.gmsh_session import gmsh_session
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.two_layers import BARE, KIRIGAMI

Cells = NDArray[np.int64]
GMSH_TRIANGLE, GMSH_QUADRILATERAL = 2, 3


KEEP_NODES = {"Mesh.RecombineOptimizeTopology": 0, "Mesh.RecombineNodeRepositioning": 0}
"""Options of gmsh: else pairing would move or remove nodes."""


def pair_triangles(mesh: PlanarMesh) -> dict[int, tuple[Cells, Cells]]:
    """Join pairs of triangles that make a good quadrilateral.

    Parameters
    ----------
    mesh : PlanarMesh
        Its nodes stay as they are, and so do the cut edges.

    Returns
    -------
    mapping of int to ((t, 3) array of int, (q, 4) array of int)
        By region (`BARE`, `KIRIGAMI`): the triangles left over, and the quadrilaterals, all
        counterclockwise.

    Raises
    ------
    ComputationError
        gmsh is not there, or fails.
    """
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    with gmsh_session(KEEP_NODES) as gmsh:
        try:
            surfaces = {region: gmsh.model.addDiscreteEntity(2) for region in (BARE, KIRIGAMI)}
            tags = np.arange(1, len(points) + 1)
            gmsh.model.mesh.addNodes(2, surfaces[KIRIGAMI], tags, points.ravel())
            for region, surface in surfaces.items():
                triangles = mesh.triangles[mesh.region == region] + 1
                gmsh.model.mesh.addElementsByType(surface, GMSH_TRIANGLE, [], triangles.ravel())
            gmsh.model.mesh.recombine()
            return {
                region: (_cells(gmsh, surface, GMSH_TRIANGLE, 3),
                         _cells(gmsh, surface, GMSH_QUADRILATERAL, 4))
                for region, surface in surfaces.items()
            }  # fmt: skip
        except Exception as error:  # gmsh raises bare Exceptions
            raise ComputationError(
                f"gmsh could not pair the triangles ({error}): take another mesh size, or wedges "
                "with --set solver.element=wedge"
            ) from error


def _cells(gmsh: Any, surface: int, kind: int, corners: int) -> Cells:
    """Nodes of the cells of one kind, counted from 0, shape (m, corners)."""
    tags = np.asarray(gmsh.model.mesh.getElementsByType(kind, surface)[1], dtype=np.int64)
    return tags.reshape(-1, corners) - 1
