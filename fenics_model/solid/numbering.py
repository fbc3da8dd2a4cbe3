"""Dofs in an order that does not depend on how the mesh is distributed.

A vector of all dofs has the displacements of the vertices, vertex by vertex in their original
order, then those of the middles of the edges, sorted by their ends' original numbers, then the
unscaled pressures of the vertices, layer by layer.
"""

import numpy as np
from numpy.typing import NDArray

from fenics_model.mesh.layered_mesh import EDGES
from fenics_model.mesh.volume_mesh import VolumeMesh
from fenics_model.solid.solid import Solid

Array = NDArray[np.float64]


class EdgeNumbers:
    """The nodes of a solid: its vertices, then the middles of its edges.

    Parameters
    ----------
    volume : VolumeMesh
        Of the solid.
    """

    def __init__(self, volume: VolumeMesh) -> None:
        self._vertices = len(volume.points)
        self._keys_of_edges = np.unique(self._keys(volume.cells[:, EDGES]))

    @property
    def count(self) -> int:
        """Number of all nodes."""
        return self._vertices + len(self._keys_of_edges)

    def middles(self, ends: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of the middles of edges, by their ends in the last axis."""
        return self._vertices + np.searchsorted(self._keys_of_edges, self._keys(ends))

    def ends(self, nodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the two vertices that each node lies between, (k, 2); a vertex is both."""
        found = np.stack([nodes, nodes], axis=-1)
        is_middle = nodes >= self._vertices
        keys = self._keys_of_edges[nodes[is_middle] - self._vertices]
        found[is_middle] = np.stack(np.divmod(keys, self._vertices), axis=-1)
        return found

    def _keys(self, ends: NDArray[np.int64]) -> NDArray[np.int64]:
        ends = np.sort(ends, axis=-1)
        return np.asarray(ends[..., 0] * self._vertices + ends[..., 1])


class Numbering:
    """The way between the dofs of a rank and those of the whole solid.

    Parameters
    ----------
    solid : Solid
        Whose dofs.

    Attributes
    ----------
    number : array of int
        Among all dofs, of each dof of this rank, those that it owns first, then its ghosts.
    """

    def __init__(self, solid: Solid) -> None:
        self._solid = solid
        self._vertices = len(solid.mesh.volume.points)
        self._edges = EdgeNumbers(solid.mesh.volume)
        self.number: NDArray[np.int64] = self._number_dofs()

    @property
    def size(self) -> int:
        """Number of all dofs."""
        layers = len(self._solid.layers)
        return 3 * self._edges.count + layers * self._vertices

    def places(self, points: Array) -> Array:
        """Return the places of all nodes of a mesh whose vertices are given, (nodes, 3), m."""
        ends = self._edges.ends(np.arange(self._edges.count))
        return np.asarray(points[ends].mean(axis=1))

    def _number_dofs(self) -> NDArray[np.int64]:
        solid, corners = self._solid, self._solid.mesh.cell_vertices
        middles = self._edges.middles(corners[:, EDGES])
        places = np.hstack([corners, middles])
        number = np.full(len(solid.unknown.x.array), -1)
        for axis in range(3):
            number[solid.component(axis).dofmap.list] = 3 * places + axis
        first = 3 * self._edges.count
        for layer in range(len(solid.layers)):
            dofs = solid.pressure_space(layer).dofmap.list
            number[dofs] = first + layer * self._vertices + corners
        return number

    def gather(self, values: Array) -> Array:
        """Return all dofs, the same on every rank.

        Parameters
        ----------
        values : array of float
            Dofs of this rank, ghosts included.
        """
        owned = slice(0, self.owned)
        gathered = np.empty(self.size)
        for numbers, found in self._solid.mesh.mesh.comm.allgather(
            (self.number[owned], values[owned])
        ):
            gathered[numbers] = found
        return gathered

    def spread(self, gathered: Array) -> Array:
        """Return the dofs of this rank, ghosts included, of all dofs.

        Raises
        ------
        ValueError
            There are more or fewer than all dofs.
        """
        values = np.asarray(gathered, dtype=np.float64)
        if values.shape != (self.size,):
            raise ValueError(f"values of the shape {values.shape}, expected {(self.size,)}")
        return values[self.number]

    @property
    def owned(self) -> int:
        """Number of dofs that this rank owns."""
        dofs = self._solid.space.dofmap
        return int(dofs.index_map.size_local * dofs.index_map_bs)

    def displacements_at(self, vertices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the numbers of the displacement dofs of vertices, (m, 3)."""
        return 3 * np.asarray(vertices)[:, None] + np.arange(3)
