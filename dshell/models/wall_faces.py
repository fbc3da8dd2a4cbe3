"""The faces beside the walls where layers end: at cuts, at the rim and at holes.

The faces whose centroids lie within some distance of a wall share it, or within a face's length if
the mesh is coarser. What the wall does to them then does not depend on the mesh.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from bilayer.geometry.surface import directed_edges
from bilayer.mesh.planar import PlanarMesh

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

ALIKE = 1e-6
"""Difference of two densities over the larger one that is none."""


@dataclass(frozen=True, eq=False)
class SharingFaces:
    """The faces on one side of some walls that share these.

    Parameters
    ----------
    faces : (k,) array of int
        Ascending.
    normals : (2, 2, k) array of float
        Two directions at right angles for each face: component, direction.
    density : (2, k) array of float
        The length of wall across each direction over the area of the faces that share it, 1/m.
    """

    faces: Numbers
    normals: Array
    density: Array


@dataclass(frozen=True, eq=False)
class WallFaces:
    """The faces beside walls of one kind: all that have the same layers on both sides.

    Parameters
    ----------
    there, beyond : frozenset of str
        Layers behind the walls, and before them; of a rim there are none before it.
    behind, before : SharingFaces
        The faces on both sides; none before a rim.
    """

    there: frozenset[str]
    beyond: frozenset[str]
    behind: SharingFaces
    before: SharingFaces

    @property
    def ending(self) -> frozenset[str]:
        """Layers that end at the walls."""
        return self.there - self.beyond


def walls_of(mesh: PlanarMesh, width: float, clamped: Numbers) -> list[WallFaces]:
    """Return the faces beside the walls of a mesh: at cuts, at its rim and at its holes.

    Parameters
    ----------
    mesh : PlanarMesh
        Which layers lie on each triangle.
    width : float
        How far from a wall the faces that share it may lie, m.
    clamped : (c, 2) array of int
        Edges of the mesh that are no free wall, as ascending pairs of nodes.
    """
    edges, behind, before = _sides_of_walls(mesh, clamped)
    sets = [*mesh.layer_sets, frozenset()]  # the last one: beyond a rim
    regions = np.append(mesh.region, len(mesh.layer_sets))
    found: dict[tuple[frozenset[str], frozenset[str]], list[Numbers]] = {}
    for pair in np.unique(np.stack([regions[behind], regions[before]]), axis=1).T:
        there, beyond = sets[pair[0]], sets[pair[1]]
        if there - beyond:
            chosen = np.flatnonzero((regions[behind] == pair[0]) & (regions[before] == pair[1]))
            found.setdefault((there, beyond), []).append(chosen)
    return [
        WallFaces(
            there,
            beyond,
            _shared(mesh, there, edges[chosen], behind[chosen], width),
            _shared(mesh, beyond, edges[chosen][:, ::-1], before[chosen], width),
        )
        for (there, beyond), parts in found.items()
        for chosen in [np.concatenate(parts)]
    ]


def _sides_of_walls(mesh: PlanarMesh, clamped: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Return edges whose two sides may differ in layers, each twice but at a rim.

    Returns
    -------
    edges : (e, 2) array of int
        Their nodes, the face behind on the left.
    behind, before : (e,) array of int
        The face on the left; that on the right, or the number of faces if there is none.
    """
    count = len(mesh.triangles)
    sides = directed_edges(mesh.triangles)
    face = np.tile(np.arange(count), 3)
    pairs, edge = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    total = np.bincount(edge, face)
    number = np.bincount(edge)[edge]
    before = np.where(number == 2, total[edge] - face, count).astype(np.int64)
    regions = np.append(mesh.region, -1)
    is_wall = regions[face] != regions[before]
    if len(clamped):
        key = np.array([len(mesh.points), 1])
        is_wall &= ~np.isin(pairs[edge] @ key, clamped @ key)
    return sides[is_wall], face[is_wall], before[is_wall]


def _shared(
    mesh: PlanarMesh, layers: frozenset[str], edges: Numbers, beside: Numbers, width: float
) -> SharingFaces:
    """Return the faces that share some walls, all with the same layers.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the walls.
    layers : frozenset of str
        On the faces; none: there are no faces.
    edges : (e, 2) array of int
        Nodes of the walls, the faces on their left.
    beside : (e,) array of int
        The face at each wall.
    width : float
        See `walls_of`.
    """
    if not layers:
        return SharingFaces(np.empty(0, np.int64), np.empty((2, 2, 0)), np.empty((2, 0)))
    start, side = mesh.points[edges[:, 0]], np.diff(mesh.points[edges], axis=1)[:, 0]
    length = np.linalg.norm(side, axis=1)
    outward = np.stack([side[:, 1], -side[:, 0]], axis=1) / length[:, None]
    wall, face = _near(mesh, layers, start, side, np.maximum(width, length))
    wall = np.concatenate([wall, np.arange(len(edges))])
    wall, face = np.unique(np.stack([wall, np.concatenate([face, beside])]), axis=1)
    share = length[wall] / np.bincount(wall, mesh.areas[face])[wall]
    faces, first, place = np.unique(face, return_index=True, return_inverse=True)
    x, y = outward[wall].T
    parts = [np.bincount(place, share * each) for each in (x * x, x * y, x * y, y * y)]
    density, normals = np.linalg.eigh(np.stack(parts, axis=1).reshape(-1, 2, 2))
    # in a corner of two equal walls all directions are alike, and round-off would choose
    alike = np.flatnonzero(density[:, 1] - density[:, 0] <= ALIKE * density[:, 1])
    x, y = outward[wall[first[alike]]].T
    normals[alike] = np.stack([x, -y, y, x], axis=1).reshape(-1, 2, 2)
    return SharingFaces(faces, normals.transpose(1, 2, 0), density.T)


def _near(
    mesh: PlanarMesh, layers: frozenset[str], start: Array, side: Array, reach: Array
) -> tuple[Numbers, Numbers]:
    """Return pairs of a wall and a face with some layers on its left and within its reach."""
    same = np.flatnonzero([mesh.layer_sets[region] == layers for region in mesh.region])
    centroids = mesh.points[mesh.triangles[same]].mean(axis=1)
    length = np.linalg.norm(side, axis=1)
    near = cKDTree(centroids).query_ball_point(start + side / 2, reach + length / 2)
    wall = np.repeat(np.arange(len(start)), [len(each) for each in near])
    face = np.concatenate([*near, np.empty(0)]).astype(np.int64)
    away, along = centroids[face] - start[wall], side[wall]
    foot = np.clip((away * along).sum(axis=1) / length[wall] ** 2, 0, 1)
    distance = np.linalg.norm(away - foot[:, None] * along, axis=1)
    is_left = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0] > 0
    inside = (distance <= reach[wall]) & is_left
    return wall[inside], same[face[inside]]
