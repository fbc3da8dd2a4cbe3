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
        Vertex over each planar node at each level, from the bottom up; -1 where there is none.
    bond : int
        The level at z = 0.
    """

    points: NDArray[np.float64]
    cells: NDArray[np.int64]
    layer: NDArray[np.int64]
    vertex_at: NDArray[np.int64]
    bond: int

    @property
    def interface(self) -> NDArray[np.int64]:
        """Vertex at z = 0 over each planar node, shape (n,)."""
        return self.vertex_at[self.bond]

    def vertices_of(self, layer: int) -> NDArray[np.int64]:
        """Vertices of the cells of a layer, ascending."""
        return np.unique(self.cells[self.layer == layer])


def extrude(mesh: PlanarMesh, slabs: Sequence[Slab], below: int = 1) -> VolumeMesh:
    """Stack slabs on the planar mesh.

    Parameters
    ----------
    mesh : PlanarMesh
        Its nodes are repeated at every level.
    slabs : sequence of Slab
        From the bottom up; one of those at z = 0 covers every triangle.
    below : int
        How many of them lie below z = 0.
    """
    n = len(mesh.points)
    bottoms = [
        sum(s.thickness for s in slabs[below:index]) - sum(s.thickness for s in slabs[index:below])
        for index in range(len(slabs))
    ]
    heights, cells, layer = [bottoms[0]], [], []
    for index, slab in enumerate(slabs):
        for element in range(slab.elements):
            bottom = np.sort(slab.triangles, axis=1) + (len(heights) - 1) * n
            prisms = np.hstack([bottom, bottom + n])
            tetrahedra = prisms[:, _PRISM_TO_TETRAHEDRA].reshape(-1, 4)
            cells.append(tetrahedra)
            layer.append(np.full(len(tetrahedra), index))
            heights.append(bottoms[index] + slab.thickness * (element + 1) / slab.elements)
    used, numbered = np.unique(np.concatenate(cells), return_inverse=True)
    vertex_at = np.full(len(heights) * n, -1)
    vertex_at[used] = np.arange(len(used))
    level, node = np.divmod(used, n)
    points = np.column_stack([mesh.points[node], np.array(heights)[level]])
    return VolumeMesh(
        points,
        numbered.reshape(-1, 4),
        np.concatenate(layer),
        vertex_at.reshape(len(heights), n),
        bond=sum(slab.elements for slab in slabs[:below]),
    )
