"""A fine mesh starts from the shape that a coarse one takes.

From flat, a fine mesh takes as many Newton iterations as a coarse one, each at its own price, and
its stiffness is indefinite on most of the way. From the coarse mesh's shape it takes a few.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, cKDTree

from bilayer.errors import BilayerError
from bilayer.mesh.generation import generate_mesh, size_for
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import MeshSize, Specimen

Array = NDArray[np.float64]

GAIN = 4
"""A mesh is fine where it has so many times the triangles of the coarse one."""
OTHER_CUT = 0.05
"""Share of the area where two meshes disagree on the kirigami, above which their cuts differ.

Two meshes of 150 and more triangles with the same cut disagree on less than 0.025."""


def coarse_mesh(specimen: Specimen, mesh: PlanarMesh, triangles: int) -> PlanarMesh | None:
    """Return a mesh of a specimen of about so many triangles, where a mesh is fine beside it.

    Parameters
    ----------
    specimen : Specimen
        What is drawn.
    mesh : PlanarMesh
        The mesh that is to be started.
    triangles : int
        Of the coarse mesh, about; 0: none.

    Returns
    -------
    PlanarMesh or None
        None where the mesh is not fine, has another cut than the specimen (a turned one, or one of
        its own), or a coarse one cannot be drawn.
    """
    if triangles == 0 or len(mesh.triangles) <= GAIN * triangles:
        return None
    size = MeshSize(size_for(triangles, specimen.characteristic_length))
    try:
        coarse = generate_mesh(replace(specimen, mesh=size))
    except BilayerError:  # gmsh is not there, or it cannot draw strips so coarsely
        return None
    if len(mesh.triangles) <= GAIN / 2 * len(coarse.triangles):
        return None
    return coarse if _disagreement(coarse, mesh) < OTHER_CUT else None


def _disagreement(coarse: PlanarMesh, fine: PlanarMesh) -> float:
    """Return the share of the area where a mesh and the nearest triangles of another differ."""
    centres, others = (mesh.points[mesh.triangles].mean(axis=1) for mesh in (fine, coarse))
    _, nearest = cKDTree(others).query(centres)
    differs = fine.region != coarse.region[nearest]
    return float(fine.areas[differs].sum() / fine.areas.sum())


def prolonged(shape: Array, coarse: PlanarMesh, fine: PlanarMesh) -> Array:
    """Return a smooth surface through the nodes of a coarse mesh at those of a fine one.

    The coarse rim is a polygon within the fine one. So that nothing is extrapolated, the fine mesh
    is shrunk into it, and the surface grows again by as much.

    Parameters
    ----------
    shape : (n, 3) array of float
        Positions of the coarse mesh's nodes, m.
    coarse, fine : PlanarMesh
        Of the same disc.

    Returns
    -------
    (m, 3) array of float
        Positions of the fine mesh's nodes, m.
    """
    from scipy.interpolate import CloughTocher2DInterpolator  # seldom needed, slow to load

    inside = -ConvexHull(coarse.points).equations[:, 2].max()  # the nearest side's distance
    share = (1 - 1e-9) * inside / np.linalg.norm(fine.points, axis=1).max()
    surface: Array = CloughTocher2DInterpolator(coarse.points, shape)(share * fine.points)
    return surface / share
