"""Planar meshes as files: every mesh that is read or written goes through here.

What a file says of the layers: the cell data `region`, or gmsh's physical groups, or nothing; then
all layers lie everywhere. A format that cannot say it is not written unless there is nothing to
say.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.files import read_mesh_file, write_mesh_file
from bilayer.mesh.formats import check_holds_layers
from bilayer.mesh.gmsh_files import PhysicalGroups, groups_by_tag
from bilayer.mesh.layers_of_groups import groups_of_sets, name_of_layers, region_by_groups
from bilayer.mesh.planar import PlanarMesh
from bilayer.mesh.validity import check_covers_once, check_nodes, check_points
from bilayer.specimen.two_layers import TWO_LAYERS

if TYPE_CHECKING:
    import meshio

PLANE_TOLERANCE = 1e-9
"""Range of z that a planar mesh in space may have, over its extent."""


def write_planar_mesh(mesh: PlanarMesh, path: str | Path) -> None:
    """Write the mesh in any format that holds it, chosen by the file's ending.

    The region is the cell data `region`. In gmsh's format each region is a physical group, whose
    name joins those of its layers: "kirigami+substrate".

    Raises
    ------
    InputError
        The format is unknown or cannot hold the layers, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> mesh = bilayer.generate_mesh(bilayer.paper_specimen())
    >>> bilayer.write_planar_mesh(mesh, folder / "mesh.vtu")
    """
    import meshio  # takes long to load, and few need it

    all_layers = frozenset().union(*mesh.layer_sets)
    used = np.unique(mesh.region)
    if any(mesh.layer_sets[number] != all_layers for number in used):
        check_holds_layers(path)
    points = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    region = mesh.region.astype(np.int32)
    data, names = {"region": [region]}, {}
    if Path(path).suffix.lower() == ".msh":
        tags = [region + 1]  # 0 would be no group
        data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        names = {
            name_of_layers(mesh.layer_sets[number]): np.array([number + 1, 2]) for number in used
        }
    cells = [("triangle", mesh.triangles)]
    write_mesh_file(meshio.Mesh(points, cells, cell_data=data, field_data=names), path)


def read_planar_mesh(
    path: str | Path, layer_sets: Sequence[frozenset[str]] = TWO_LAYERS
) -> PlanarMesh:
    """Read a mesh in any format that meshio reads; without a region all layers lie everywhere.

    A drawing's construction points are left out: the nodes of nothing but points and lines, and in
    gmsh's files those of nothing at all. A sheet whose triangles all run clockwise, seen from
    below, is turned over.

    Parameters
    ----------
    path : path-like
        The file.
    layer_sets : sequence of frozenset of str
        The layers that its regions stand for, see `bilayer.specimen.specimen.Specimen.layer_sets`;
        a bilayer's if left out. For physical groups see `bilayer.mesh.layers_of_groups`.

    Raises
    ------
    InputError
        The file cannot be read, holds other than triangles in a plane z = constant, has groups of
        no layers, or makes no valid planar mesh.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> mesh = bilayer.generate_mesh(bilayer.paper_specimen())
    >>> bilayer.write_planar_mesh(mesh, folder / "mesh.vtk")
    >>> bilayer.read_planar_mesh(folder / "mesh.vtk").same_as(mesh)
    True
    """
    data, groups = read_mesh_file(path)
    try:
        mesh = _planar(data, groups, tuple(layer_sets))
        check_covers_once(mesh.points, mesh.triangles)
        return mesh
    except InputError as error:
        raise InputError(f"mesh file {path}: {error}") from error


def _planar(
    data: "meshio.Mesh", groups: PhysicalGroups | None, layer_sets: tuple[frozenset[str], ...]
) -> PlanarMesh:
    triangles = data.get_cells_type("triangle")
    others = [block.type for block in data.cells if block.dim > 1 and block.type != "triangle"]
    if len(triangles) == 0 or others:
        found = f"{others[0]} cells" if others else "no triangles"
        raise InputError(f"holds {found}, expected a planar mesh of triangles of 3 nodes")
    if data.points.ndim != 2 or data.points.shape[1] not in (2, 3):
        raise InputError(
            f"its nodes have the shape {data.points.shape}, expected 2 or 3 numbers each"
        )
    check_nodes(len(data.points), triangles)
    kept = np.setdiff1d(np.arange(len(data.points)), _construction(data, triangles, groups))
    points = data.points[kept]
    check_points(points)
    heights, extent = points[:, 2:], np.ptp(points[:, :2], axis=0).max()
    if np.ptp(heights, axis=0).max(initial=0.0) > PLANE_TOLERANCE * extent:
        raise InputError(
            f"its z goes from {heights.min():g} to {heights.max():g} m, expected a plane"
        )
    numbered = _seen_from_above(points, np.searchsorted(kept, triangles))
    region = _region(data, groups, layer_sets)
    if region is None:
        region = np.full(len(triangles), len(layer_sets) - 1)
    return PlanarMesh(points[:, :2], numbered, region, layer_sets)


def _construction(
    data: "meshio.Mesh", triangles: NDArray[np.int64], groups: PhysicalGroups | None
) -> NDArray[np.int64]:
    """Return the nodes that belong to a drawing and not to the sheet."""
    if groups is not None:  # the centres of circles
        return np.setdiff1d(np.arange(len(data.points)), triangles)
    drawn = [block.data.ravel() for block in data.cells if block.dim < 2]
    return np.setdiff1d(np.concatenate([np.empty(0, dtype=np.int64), *drawn]), triangles)


def _seen_from_above(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> NDArray[np.int64]:
    a, b, c = np.moveaxis(points[triangles][:, :, :2], 1, 0)
    turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return triangles[:, ::-1] if (turn < 0).all() else triangles


def _region(
    data: "meshio.Mesh", groups: PhysicalGroups | None, layer_sets: tuple[frozenset[str], ...]
) -> NDArray[np.int64] | None:
    """Return the region of each triangle as the file tells it; None if it does not."""
    if "region" in data.cell_data:
        region: NDArray[np.int64] = data.get_cell_data("region", "triangle")
        return region
    if groups is None:
        groups = groups_of_sets(data, layer_sets)
    if groups is None and "gmsh:physical" in data.cell_data:  # a file made of gmsh's by meshio
        groups = groups_by_tag(data.get_cell_data("gmsh:physical", "triangle"), {})
    return None if groups is None else region_by_groups(groups, layer_sets)
