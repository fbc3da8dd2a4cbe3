"""The planar mesh of a specimen, made by gmsh with the cut edges in it."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError, NotEnoughMemoryError
from bilayer.mesh.agreement import check_agreement
from bilayer.mesh.bonding import check_bonding
from bilayer.mesh.divided_sheet import DividedSheet
from bilayer.mesh.drawing import TRIANGLES_PER_AREA, Drawing
from bilayer.mesh.gmsh_session import gmsh_session
from bilayer.mesh.planar import PlanarMesh
from bilayer.mesh.sector_disc import SectorDisc
from bilayer.mesh.validity import doubled_areas_and_longest_sides
from bilayer.runtime.memory import available_memory
from bilayer.specimen.specimen import Specimen

BYTES_PER_TRIANGLE = 2000
"""Memory that gmsh and the arrays of the mesh take (measured: 1.3 to 1.9 kB per triangle)."""


FLATTEST = 1e-3
"""Height of a triangle over its longest edge. With flatter ones no solver gets far."""


def size_for(triangles: int, radius: float) -> float:
    """Return the mesh size that gives a sheet about so many triangles, m.

    `radius` is that of the circle of its area, `Specimen.characteristic_length`.
    """
    return radius * math.sqrt(math.pi * TRIANGLES_PER_AREA / triangles)


def drawing_of(specimen: Specimen) -> Drawing:
    """Return the drawing of a specimen's sheet."""
    return SectorDisc.of(specimen) or DividedSheet.of(specimen)


def estimated_triangles(specimen: Specimen) -> float:
    """Return the number of triangles to expect."""
    return drawing_of(specimen).triangles()


def check_memory(
    specimen: Specimen, bytes_per_triangle: float, what: str, available: float | None = None
) -> None:
    """Raise NotEnoughMemoryError if the mesh size asks for more memory than there is.

    Parameters
    ----------
    specimen : Specimen
        Its outline, patterns and mesh size tell the number of triangles.
    bytes_per_triangle : float
        What the step named `what` takes.
    what : str
        For the message: "the mesh", "the finite-element model", ...
    available : float, optional
        Bytes; what this machine has if left out.
    """
    count = estimated_triangles(specimen)
    triangles = f"mesh.size = {specimen.mesh.size} m: about {count:.3g}"
    _check_available(triangles, count * bytes_per_triangle, what, available)


def mesh_within_memory(
    specimen: Specimen,
    mesh: PlanarMesh | None,
    bytes_per_triangle: float,
    what: str,
    available: float | None = None,
) -> PlanarMesh:
    """Return a given mesh, or that of a specimen, if there is the memory to go on with it.

    A given mesh has to be one of the specimen.

    Parameters
    ----------
    specimen : Specimen
        To be meshed if there is no mesh.
    mesh : PlanarMesh or None
        The mesh that is given.
    bytes_per_triangle, what, available
        See `check_memory`.

    Raises
    ------
    NotEnoughMemoryError
        There is less memory than needed.
    InputError
        The mesh is not one of the specimen, or its layers are not bonded to each other everywhere.
    ComputationError
        gmsh is not there, or fails.
    """
    if mesh is None:
        check_memory(specimen, bytes_per_triangle, what, available)
        mesh = generate_mesh(specimen)
    else:
        check_agreement(specimen, mesh)
        count = len(mesh.triangles)
        _check_available(f"mesh: its {count}", count * bytes_per_triangle, what, available)
    check_bonding(specimen, mesh)
    return mesh


def _check_available(triangles: str, needed: float, what: str, available: float | None) -> None:
    there_is = available_memory() if available is None else available
    if needed > there_is:
        raise NotEnoughMemoryError(
            f"{triangles} triangles would take {needed / 2**30:.3g} GiB for {what}, expected at "
            f"most the {there_is / 2**30:.3g} GiB of memory available"
        )


def generate_mesh(specimen: Specimen) -> PlanarMesh:
    """Mesh the bonded flat sheet of a specimen.

    Parameters
    ----------
    specimen : Specimen
        Outline, patterns and mesh sizes.

    Returns
    -------
    PlanarMesh
        With the layers that lie on each triangle; the cut edges are edges of the mesh.

    Raises
    ------
    InputError
        Two edges of the sheet are nearly one.
    NotEnoughMemoryError
        The mesh would not fit into memory.
    ComputationError
        gmsh is not there, or fails.

    Examples
    --------
    >>> import bilayer
    >>> mesh = bilayer.generate_mesh(bilayer.paper_specimen())
    >>> mesh.points.shape[1], mesh.triangles.shape[1]
    (2, 3)
    """
    check_memory(specimen, BYTES_PER_TRIANGLE, "the mesh")
    with gmsh_session() as gmsh:
        try:
            parts = drawing_of(specimen).draw(gmsh)
            gmsh.model.mesh.generate(2)
            triangles = [_triangles(gmsh, part.surfaces) for part in parts]
            tags, coordinates, _ = gmsh.model.mesh.getNodes()
        except Exception as error:  # gmsh raises bare Exceptions
            raise ComputationError(f"gmsh could not mesh the specimen: {error}") from error
    sets = specimen.layer_sets
    numbers = [sets.index(part.layers) for part in parts]
    region = np.repeat(numbers, [len(part) for part in triangles])
    points, numbered = _numbered_from_zero(tags, coordinates, np.concatenate(triangles))
    _check_flatness(points[numbered])
    return PlanarMesh(points, numbered, region, sets)


def _check_flatness(corners: NDArray[np.float64]) -> None:
    """Raise InputError if a triangle, of the corners (m, 3, 2), is too flat for any solver."""
    doubled, longest = doubled_areas_and_longest_sides(corners)
    height = np.abs(doubled) / longest
    flattest = int(np.argmin(height / longest))
    if height[flattest] < FLATTEST * longest[flattest]:
        x, y = 1e3 * corners[flattest].mean(axis=0)
        raise InputError(
            f"the sheet has two edges {1e6 * height[flattest]:.2g} um from each other at x, y = "
            f"{x:.3f}, {y:.3f} mm: expected one edge, or {FLATTEST:g} of a triangle's length "
            "between them (mesh.corner_size makes shorter ones)"
        )


def _triangles(gmsh: Any, surfaces: Sequence[int]) -> NDArray[np.int64]:
    """Node tags of the triangles of some surfaces, counterclockwise, shape (m, 3)."""
    parts = [gmsh.model.mesh.getElementsByType(2, surface)[1] for surface in surfaces]
    return np.concatenate([np.empty(0), *parts]).astype(np.int64).reshape(-1, 3)


def _numbered_from_zero(
    tags: NDArray[Any], coordinates: NDArray[Any], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the points (n, 2), m, and the triangles (m, 3), without nodes of no triangle."""
    used, renumbered = np.unique(triangles, return_inverse=True)
    order = np.argsort(tags)
    rows = order[np.searchsorted(tags[order], used)]
    return coordinates.reshape(-1, 3)[rows, :2], renumbered.reshape(-1, 3)
