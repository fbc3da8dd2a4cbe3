"""The nodes, edges and triangles of a planar mesh that belong to a part of the sheet."""

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.part import Part
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.supported import Support

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

ON_LINE = 1e-5
"""Distance over the extent of the mesh up to which a node lies on a line or a limit."""
AXES = {"x": 0, "y": 1, "z": 2}


def nodes_of(part: Part, mesh: PlanarMesh, field: str) -> Numbers:
    """Return the nodes of a part, ascending.

    Parameters
    ----------
    part : Part
        Of the sheet.
    mesh : PlanarMesh
        Of the sheet.
    field : str
        Where the part stands in a file, for the message.

    Raises
    ------
    InputError
        There is no node in it.
    """
    if part.point is not None:
        return np.array([np.argmin(np.linalg.norm(mesh.points - part.point, axis=1))])
    nodes = np.flatnonzero(_lies_in(part, mesh.points, mesh) & _is_on(part, mesh))
    if len(nodes) == 0:
        hint = "; a line runs from edge to edge of the sheet, or is closed" if part.line else ""
        raise InputError(f"{field} = {part}: no node of the mesh lies there, expected one{hint}")
    return nodes


def edges_of(part: Part, mesh: PlanarMesh, field: str) -> Numbers:
    """Return the edges of a part, (k, 2): of its border or line, or all between its nodes."""
    nodes = nodes_of(part, mesh, field)
    edges = mesh.edges if part.on == "sheet" else mesh.boundary_edges
    inside = edges[np.isin(edges, nodes).all(axis=1)]
    if part.line:
        inside = inside[_on_line(part, mesh.points[inside].mean(axis=1), mesh)]
    return inside


def faces_of(part: Part, mesh: PlanarMesh, field: str) -> Numbers:
    """Return the triangles whose centroids lie in a region, ascending; InputError if none does."""
    centroids = mesh.points[mesh.triangles].mean(axis=1)
    faces = np.flatnonzero(_lies_in(part, centroids, mesh))
    if len(faces) == 0:
        raise InputError(f"{field} = {part}: no triangle of the mesh lies there, expected one")
    return faces


def node_shares(part: Part, mesh: PlanarMesh, field: str) -> tuple[Numbers, Array]:
    """Return the nodes of a part and the share of a force spread evenly over it that each takes."""
    nodes = nodes_of(part, mesh, field)
    if part.on == "sheet" and part.point is None and not part.line:
        faces = mesh.triangles[np.isin(mesh.triangles, nodes).all(axis=1)]
        sizes = mesh.areas[np.isin(mesh.triangles, nodes).all(axis=1)]
    else:
        faces = edges_of(part, mesh, field)
        sizes = np.linalg.norm(np.diff(mesh.points[faces], axis=1)[:, 0], axis=1)
    if len(faces) == 0:  # single nodes
        return nodes, np.full(len(nodes), 1 / len(nodes))
    weights = np.bincount(
        faces.reshape(-1), np.repeat(sizes, faces.shape[1]), minlength=len(mesh.points)
    )
    return nodes, weights[nodes] / weights[nodes].sum()


def supported_coordinates(specimen: Specimen, mesh: PlanarMesh) -> Numbers:
    """Return the coordinates that supports hold, rows (node, axis), (k, 2)."""
    rows = [
        np.column_stack([nodes, np.full(len(nodes), AXES[axis])])
        for support in specimen.supports
        for nodes in [nodes_of(support.part, mesh, field_of(support))]
        for axis in support.axes
    ]
    return np.unique(np.concatenate([np.empty((0, 2), dtype=np.int64), *rows]), axis=0)


def clamped_edges(specimen: Specimen, mesh: PlanarMesh) -> Numbers:
    """Return the edges about which the sheet cannot turn, as ascending node pairs, (k, 2)."""
    rows = [
        edges_of(support.part, mesh, field_of(support))
        for support in specimen.supports
        if support.keeps_slope
    ]
    return np.unique(np.concatenate([np.empty((0, 2), dtype=np.int64), *rows]), axis=0)


def field_of(support: Support) -> str:
    """Return where the part of a support stands in a file."""
    return f"supports.{support.name}.where"


def check_pressed(specimen: Specimen, mesh: PlanarMesh) -> None:
    """Raise InputError if the edge of a sheet under pressure is not held.

    The work of a pressure is that on the volume which the sheet closes. A free edge would let it
    escape, and its forces would have no energy.
    """
    held = supported_coordinates(specimen, mesh)
    level = held[held[:, 1] == AXES["z"], 0]
    for load in specimen.loads:
        if load.kind != "pressure":
            continue
        field = f"loads.{load.name}.where"
        free = np.setdiff1d(mesh.edges_of(faces_of(load.part, mesh, field)), level)
        if len(free):
            x, y = 1e3 * mesh.points[free[0]]
            raise InputError(
                f"{field} = {load.part}: its edge is not held in z at ({x:.4g}, {y:.4g}) mm, "
                "expected [supports] all around what a pressure acts on"
            )


def _is_on(part: Part, mesh: PlanarMesh) -> NDArray[np.bool_]:
    """Return for each node whether it is on the border that a part is one of."""
    on = np.ones(len(mesh.points), dtype=bool)
    if part.on != "sheet":
        on[:] = False
        on[mesh.boundary_edges] = True
        is_rim = np.isin(np.arange(len(on)), mesh.rim_nodes)
        on &= is_rim if part.on == "rim" else ~is_rim
    return on


def _lies_in(part: Part, points: Array, mesh: PlanarMesh) -> NDArray[np.bool_]:
    """Return for each point whether the limits hold there, and whether it is on the line."""
    inside = np.ones(len(points), dtype=bool)
    values = {"x": points[:, 0], "y": points[:, 1], "r": np.linalg.norm(points, axis=1)}
    near = ON_LINE * np.ptp(mesh.points)
    for limit in part.limits:
        beyond = values[limit.measured] - limit.bound
        inside &= beyond <= near if limit.relation == "<=" else beyond >= -near
    return inside & _on_line(part, points, mesh) if part.line else inside


def _on_line(part: Part, points: Array, mesh: PlanarMesh) -> NDArray[np.bool_]:
    distance = shapely.distance(part.drawn, shapely.points(points))
    return np.asarray(distance <= ON_LINE * np.ptp(mesh.points))
