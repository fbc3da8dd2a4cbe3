"""The volume mesh: slabs of prisms on the triangles of the planar mesh, cut into tetrahedra.

A prism over a triangle whose nodes are sorted a < b < c becomes the tetrahedra a0 b0 c0 c1,
a0 b0 b1 c1 and a0 a1 b1 c1 (0 below, 1 above). Each side's diagonal then runs from the lower
node's bottom to the higher node's top, so that neighbours agree without knowing each other.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh

_PRISM_TO_TETRAHEDRA = np.array([[0, 1, 2, 5], [0, 1, 4, 5], [0, 3, 4, 5]])


@dataclass(frozen=True)
class Slab:
    """One layer to be extruded.

    Parameters
    ----------
    thickness : float
        In the mesh, m.
    elements : int
        Number of elements through it.
    triangles : (k, 3) array of int
        The planar triangles that it covers.
    """

    thickness: float
    elements: int
    triangles: NDArray[np.int64]


@dataclass(frozen=True)
class VolumeMesh:
    """Tetrahedra in layers.

    Parameters
    ----------
    points : (v, 3) array of float
        Vertices, m.
    cells : (c, 4) array of int
        Vertices of each tetrahedron.
    layer : (c,) array of int
        Layer of each tetrahedron, 0 for the lowest.
    vertex_at : (levels, n) array of int
        Vertex over each planar node at each level, from the bottom up; -1 if there is none.
    heights : (levels,) array of float
        Of the levels, m.
    layer_between : (levels - 1,) array of int
        Layer between each level and the next.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    layer: NDArray[np.int64]
    vertex_at: NDArray[np.int64]
    heights: NDArray[np.float64]
    layer_between: NDArray[np.int64]

    @property
    def reference_level(self) -> int:
        """The level at z = 0."""
        return int(np.flatnonzero(self.heights == 0)[0])

    @property
    def reference_surface(self) -> NDArray[np.int64]:
        """Vertex at z = 0 over each planar node, shape (n,)."""
        return self.vertex_at[self.reference_level]

    @property
    def planar_nodes(self) -> NDArray[np.int64]:
        """The planar node under each vertex, (v,)."""
        nodes = np.empty(len(self.points), dtype=np.int64)
        for row in self.vertex_at:
            there = np.flatnonzero(row >= 0)
            nodes[row[there]] = there
        return nodes

    def lowest_faces(self, triangles: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the vertices of the lowest face over each of some planar triangles, (k, 3)."""
        faces = np.concatenate([np.delete(self.cells, corner, axis=1) for corner in range(4)])
        heights = self.points[faces, 2]
        faces = faces[np.ptp(heights, axis=1) == 0]
        corners = np.sort(self.planar_nodes[faces], axis=1)
        order = np.lexsort((self.points[faces[:, 0], 2], *corners.T[::-1]))
        corners, faces = corners[order], faces[order]
        is_first = np.ones(len(corners), dtype=bool)
        is_first[1:] = (corners[1:] != corners[:-1]).any(axis=1)
        key = np.array([len(self.vertex_at[0]) ** 2, len(self.vertex_at[0]), 1])
        wanted = np.isin(corners[is_first] @ key, np.sort(triangles, axis=1) @ key)
        return np.asarray(faces[is_first][wanted])

    def vertices_of(self, layer: int) -> NDArray[np.int64]:
        """Vertices of the cells of a layer, ascending."""
        return np.unique(self.cells[self.layer == layer])


def extrude(mesh: PlanarMesh, slabs: Sequence[Slab], below: float = 1.0) -> VolumeMesh:
    """Stack slabs on the planar mesh, a layer each.

    Parameters
    ----------
    mesh : PlanarMesh
        Its nodes are repeated at every level.
    slabs : sequence of Slab
        From the bottom up; one of those at z = 0 covers every triangle.
    below : float
        How many of them lie below z = 0: 1.5 is the first and half of the second, whose elements
        then must have a level there.
    """
    n = len(mesh.points)
    heights = _heights(slabs, below)
    layer_between = np.repeat(np.arange(len(slabs)), [slab.elements for slab in slabs])
    mirrored = 0 if float(below).is_integer() else np.flatnonzero(heights == 0)[0]
    cells = [
        _tetrahedra(slabs[index].triangles, n * level, n * (level + 1), level < mirrored)
        for level, index in enumerate(layer_between)
    ]
    layer = np.repeat(layer_between, [len(part) for part in cells])
    used, numbered = np.unique(np.concatenate(cells), return_inverse=True)
    vertex_at = np.full(len(heights) * n, -1)
    vertex_at[used] = np.arange(len(used))
    level, node = np.divmod(used, n)
    return VolumeMesh(
        np.column_stack([mesh.points[node], heights[level]]),
        numbered.reshape(-1, 4),
        layer,
        vertex_at.reshape(len(heights), n),
        heights,
        layer_between,
    )


def _tetrahedra(
    triangles: NDArray[np.int64], bottom: int, top: int, is_mirrored: bool
) -> NDArray[np.int64]:
    """Return the prisms on triangles, cut into tetrahedra, or into those of the mirror image.

    The nodes below and above are numbered by so many more than those of the triangles.
    """
    corners = np.sort(triangles, axis=1)
    levels = (top, bottom) if is_mirrored else (bottom, top)
    prisms = np.hstack([corners + level for level in levels])
    return prisms[:, _PRISM_TO_TETRAHEDRA].reshape(-1, 4)


def _heights(slabs: Sequence[Slab], below: float) -> NDArray[np.float64]:
    """Return the heights of all levels, m."""
    whole = int(below)
    thicknesses = [slab.thickness for slab in slabs]
    part = (below - whole) * thicknesses[whole] if below > whole else 0.0
    bottoms = [
        sum(thicknesses[whole:index]) - sum(thicknesses[index:whole]) - part
        for index in range(len(slabs))
    ]
    heights = [bottoms[0]]
    for bottom, slab in zip(bottoms, slabs, strict=True):
        steps = range(1, slab.elements + 1)
        heights += [bottom + slab.thickness * step / slab.elements for step in steps]
    level = sum(slab.elements for slab in slabs[:whole])
    if below > whole:
        level += int((below - whole) * slabs[whole].elements)
    if abs(heights[level]) > 1e-9 * sum(thicknesses):
        raise ValueError(f"below = {below}: expected a level of the mesh")
    heights[level] = 0.0  # but for round-off
    return np.array(heights)
