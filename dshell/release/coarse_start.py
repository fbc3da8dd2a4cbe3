"""Start of a fine mesh from the shape on a coarse one.

From flat, a fine mesh takes as many Newton iterations as a coarse one, and each costs more. Its
stiffness is indefinite on most of the way. From the shape on the coarse mesh it takes a few.
"""

from collections.abc import Callable
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
"""A mesh is fine if it has so many times the triangles of the coarse one."""
OTHER_CUT = 0.05
"""Share of the area where two meshes disagree on the layers, above which their patterns differ.

Two meshes of 150 and more triangles with the same patterns disagree on less than 0.035."""


def coarse_mesh(
    specimen: Specimen,
    mesh: PlanarMesh,
    triangles: int,
    draw: Callable[[Specimen], PlanarMesh] = generate_mesh,
) -> PlanarMesh | None:
    """Return a mesh of a specimen of about so many triangles, if a mesh is fine beside it.

    Parameters
    ----------
    specimen : Specimen
        What is drawn.
    mesh : PlanarMesh
        The mesh that is to be started.
    triangles : int
        Of the coarse mesh, about; 0: none.
    draw : callable
        Makes the planar mesh of a specimen.

    Returns
    -------
    PlanarMesh or None
        None if the mesh is not fine, has other patterns than the specimen (turned ones, or some of
        its own), or a coarse one cannot be drawn.
    """
    if triangles == 0 or len(mesh.triangles) <= GAIN * triangles:
        return None
    size = MeshSize(size_for(triangles, specimen.characteristic_length))
    try:
        coarse = draw(replace(specimen, mesh=size))
    except BilayerError:  # gmsh is not there, or it cannot draw strips so coarsely
        return None
    if len(mesh.triangles) <= GAIN / 2 * len(coarse.triangles):
        return None
    return coarse if _disagreement(coarse, mesh) < OTHER_CUT else None


def _disagreement(coarse: PlanarMesh, fine: PlanarMesh) -> float:
    """Return the share of the area where a mesh and the nearest triangles of another differ."""
    centres, others = (mesh.points[mesh.triangles].mean(axis=1) for mesh in (fine, coarse))
    _, nearest = cKDTree(others).query(centres)
    numbers = {names: number for number, names in enumerate(coarse.layer_sets)}
    region = np.array([numbers.get(names, -1) for names in fine.layer_sets])[fine.region]
    differs = region != coarse.region[nearest]
    return float(fine.areas[differs].sum() / fine.areas.sum())


def prolong_shape(shape: Array, coarse: PlanarMesh, fine: PlanarMesh) -> Array:
    """Return a smooth surface through the nodes of a coarse mesh at those of a fine one.

    The coarse rim is a polygon within the fine one. So that nothing is extrapolated there, the fine
    mesh is shrunk into the convex hull of the coarse one, and the surface grows again by as much.

    Parameters
    ----------
    shape : (n, 3) array of float
        Positions of the coarse mesh's nodes, m.
    coarse, fine : PlanarMesh
        Of the same sheet.

    Returns
    -------
    (m, 3) array of float
        Positions of the fine mesh's nodes, m.
    """
    from dshell.release.smooth_surface import SmoothSurface  # seldom needed, slow to load

    centre = coarse.centroid
    share = (1 - 1e-9) * _share_within_hull(coarse.points - centre, fine, centre)

    surface = SmoothSurface(coarse, shape).at(centre + share * (fine.points - centre))
    grown: Array = np.divide(surface, share)
    return grown


def _share_within_hull(hull: Array, fine: PlanarMesh, centre: Array) -> float:
    """Return the factor by which a fine mesh shrinks about a centre to lie in a hull.

    The rim between two nodes is taken to bulge as a circle around the centre does, so that the
    share does not depend on where exactly its nodes lie.

    Parameters
    ----------
    hull : (n, 2) array of float
        The points, from the centre, m.
    fine : PlanarMesh
        What shrinks.
    centre : (2,) array of float
        Within the hull, m.
    """
    sides = ConvexHull(hull).equations
    normals, distances = sides[:, :2], -sides[:, 2]
    points = fine.points - centre
    x, y = np.moveaxis(points[fine.boundary_edges], 2, 0)  # of both ends of each edge
    along = np.multiply.outer(normals[:, 0], x) + np.multiply.outer(normals[:, 1], y)
    aside = np.multiply.outer(normals[:, 0], y) - np.multiply.outer(normals[:, 1], x)
    passed = (along > 0).all(axis=2) & (aside.min(axis=2) <= 0) & (aside.max(axis=2) >= 0)
    bulge = np.where(passed, np.hypot(x, y).max(axis=1), 0.0).max(axis=1)
    reach = np.maximum((points @ normals.T).max(axis=0), bulge)
    return float(min(1.0, (distances / reach).min()))
