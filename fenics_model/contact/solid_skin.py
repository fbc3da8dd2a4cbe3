"""The skin of the layered solid: its boundary, each side of a tetrahedron in four flat triangles.

The sides are curved, their six nodes (corners and middles of edges) carry the displacement. The
four triangles between these nodes are where the contact looks. A fibre is what lies over one node
of the planar mesh, or over the middle of one of its edges.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import directed_edges
from bilayer.mesh.planar import PlanarMesh
from fenics_model.mesh.volume_mesh import VolumeMesh
from fenics_model.solid.numbering import EdgeNumbers

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

_SIDES = np.array([[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]])
"""Corners of a tetrahedron's sides, each opposite to the corner of its number."""
_QUARTERS = np.array([[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]])
"""Triangles of a side with the corners 0, 1, 2 and the middles 3, 4, 5 of 01, 12, 20."""


@dataclass(frozen=True, eq=False)
class SolidSkin:
    """The skin of a solid; see `bilayer.contact.touching.Covering` for its triangles.

    Parameters
    ----------
    mesh_triangles : (m, 3) array of int
        The planar mesh.
    triangles : (t, 3) array of int
        The closed skin, turned outward, by its points.
    face : (t,) array of int
        The mesh's triangle over or under which each of them lies.
    node : (k,) array of int
        The solid's node that each point is: its vertices, then the middles of its edges.
    flat : (k, 3) array of float
        The points as the mesh is drawn, m.
    fibre : (k,) array of int
        The fibre of each point.
    neighbours : (p, 2) array of int
        Pairs of fibres that are neighbours.
    """

    mesh_triangles: Indices
    triangles: Indices
    face: Indices
    node: Indices
    flat: Array
    fibre: Indices
    neighbours: Indices

    @classmethod
    def of(cls, volume: VolumeMesh, mesh: PlanarMesh) -> "SolidSkin":
        """Return the skin of an extruded mesh."""
        sides, cell = _boundary(volume)
        edges = EdgeNumbers(volume)
        following = np.roll(sides, -1, axis=1)
        middles = edges.middles(np.stack([sides, following], axis=-1))
        triangles = np.hstack([sides, middles])[:, _QUARTERS].reshape(-1, 3)
        node, place = np.unique(triangles, return_inverse=True)
        ends = edges.ends(node)
        return cls(
            mesh.triangles,
            place.reshape(-1, 3),
            np.repeat(_faces_of(volume, mesh)[cell], len(_QUARTERS)),
            node,
            volume.points[ends].mean(axis=1),
            *_fibres(volume, mesh, ends),
        )


def _boundary(volume: VolumeMesh) -> tuple[Indices, Indices]:
    """Return the sides that only one cell has, turned outward, (s, 3), and their cells, (s,)."""
    sides = volume.cells[:, _SIDES].reshape(-1, 3)
    _, first, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = np.sort(first[count == 1])
    cell, opposite = np.divmod(outer, len(_SIDES))
    found = sides[outer]
    a, b, c = np.moveaxis(volume.points[found], 1, 0)
    inward = volume.points[volume.cells[cell, opposite]] - a
    is_turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), inward) > 0
    return np.where(is_turned[:, None], found[:, ::-1], found), cell


def _planar_nodes(volume: VolumeMesh) -> Indices:
    """Return the node of the planar mesh under each vertex, (v,)."""
    level, node = np.nonzero(volume.vertex_at >= 0)
    under = np.empty(len(volume.points), dtype=np.int64)
    under[volume.vertex_at[level, node]] = node
    return under


def _faces_of(volume: VolumeMesh, mesh: PlanarMesh) -> Indices:
    """Return the planar triangle that each cell was extruded from, (c,)."""
    a, b, c, d = np.sort(_planar_nodes(volume)[volume.cells], axis=1).T  # one node comes twice
    corners = np.column_stack([a, np.where(b == a, c, b), d])
    count = len(mesh.points)
    keys, wanted = (_triangle_keys(found, count) for found in (mesh.triangles, corners))
    order = np.argsort(keys)
    return np.asarray(order[np.searchsorted(keys, wanted, sorter=order)])


def _triangle_keys(corners: Indices, count: int) -> Indices:
    a, b, c = np.sort(corners, axis=1).T
    return np.asarray((a * count + b) * count + c)


def _fibres(volume: VolumeMesh, mesh: PlanarMesh, ends: Indices) -> tuple[Indices, Indices]:
    """Return the fibre of each point, by the ends of its edge, and which are neighbours."""
    count = len(mesh.points)
    corners = mesh.triangles
    sides = np.stack([corners, np.roll(corners, -1, axis=1)], axis=-1)
    keys, place = np.unique(_edge_keys(sides, count), return_inverse=True)
    one, other = _planar_nodes(volume)[ends].T
    on_edge = count + np.searchsorted(keys, _edge_keys(np.column_stack([one, other]), count))
    middles = count + place.reshape(corners.shape)
    quarters = np.hstack([corners, middles])[:, _QUARTERS].reshape(-1, 3)
    pairs = np.sort(directed_edges(quarters), axis=1)
    return np.where(one == other, one, on_edge), np.unique(pairs, axis=0)


def _edge_keys(ends: Indices, count: int) -> Indices:
    ends = np.sort(ends, axis=-1)
    return np.asarray(ends[..., 0] * count + ends[..., 1])
