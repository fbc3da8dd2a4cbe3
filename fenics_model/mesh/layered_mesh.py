"""The volume mesh, distributed over the ranks, and the way back to its original vertex numbers.

Everything that must not depend on the partition (which dofs are held, where a layer's pressure
lives, the order of gathered results) goes through the original numbers.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import basix.ufl
import dolfinx
import numpy as np
import ufl
from mpi4py import MPI
from numpy.typing import NDArray

from fenics_model.api import dolfinx_api
from fenics_model.mesh.volume_mesh import VolumeMesh

EDGES = np.array([[2, 3], [1, 3], [1, 2], [0, 3], [0, 2], [0, 1]])
"""Ends of a tetrahedron's edges among its vertices, in Basix's order."""


class LayeredMesh:
    """A volume mesh that dolfinx has distributed.

    Parameters
    ----------
    volume : VolumeMesh
        The same on every rank.
    comm : MPI.Comm
        The ranks.

    Attributes
    ----------
    mesh : dolfinx.mesh.Mesh
        This rank's part.
    layer_tags : dolfinx.mesh.MeshTags
        Layer of each cell.
    cell_vertices : (cells, 4) array of int
        Original numbers of the vertices of this rank's cells.
    """

    def __init__(self, volume: VolumeMesh, comm: MPI.Comm) -> None:
        self.volume = volume
        mine = slice(None) if comm.rank == 0 else slice(0, 0)
        domain = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
        self.mesh = dolfinx_api.create_mesh(comm, volume.cells[mine], volume.points[mine], domain)
        nodes = dolfinx_api.geometry_dofmap(self.mesh)
        cells = np.arange(len(nodes), dtype=np.int32)
        layers = volume.layer[self.mesh.topology.original_cell_index].astype(np.int32)
        self.layer_tags = dolfinx.mesh.meshtags(self.mesh, 3, cells, layers)
        original = np.asarray(self.mesh.geometry.input_global_indices)
        self.cell_vertices: NDArray[np.int64] = original[nodes]
        self._original = original

    @contextmanager
    def drawn_at(self, points: NDArray[np.float64]) -> Iterator[None]:
        """Draw the mesh with its vertices elsewhere meanwhile.

        Parameters
        ----------
        points : (v, 3) array of float
            Vertices in their original order, m.
        """
        places = self.mesh.geometry.x
        before = places.copy()
        places[:] = points[self._original]
        try:
            yield
        finally:
            places[:] = before

    def vertices_of_facets(self, facets: NDArray[np.int32]) -> NDArray[np.int64]:
        """Return the original numbers of the vertices of this rank's facets, (n, 3)."""
        if len(facets) == 0:
            return np.empty((0, 3), dtype=np.int64)
        self.mesh.topology.create_connectivity(2, 3)
        nodes = dolfinx.mesh.entities_to_geometry(self.mesh, 2, facets)
        return np.asarray(self._original[nodes], dtype=np.int64)

    def dofs_at(self, space: Any, vertices: NDArray[np.int64]) -> NDArray[np.int32]:
        """Dofs of a scalar Lagrange (sub)space at some original vertices, those seen by this rank.

        Parameters
        ----------
        space : dolfinx.fem.FunctionSpace
            A space or a `sub` of one; its cells' first four dofs are those of the vertices.
        vertices : array of int
            Original numbers.
        """
        chosen = np.isin(self.cell_vertices, vertices)
        return np.unique(space.dofmap.list[:, :4][chosen]).astype(np.int32)

    def gather(self, space: Any, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values of a scalar Lagrange (sub)space at all vertices, in their original order.

        Parameters
        ----------
        space : dolfinx.fem.FunctionSpace
            A space or a `sub` of one.
        values : array of float
            This rank's dofs, ghosts included.

        Returns
        -------
        (v,) array of float
            The same on every rank.
        """
        vertices, first = np.unique(self.cell_vertices, return_index=True)
        pairs = vertices, values[space.dofmap.list[:, :4].ravel()[first]]
        gathered = np.full(len(self.volume.points), np.nan)
        for numbers, found in self.mesh.comm.allgather(pairs):
            gathered[numbers] = found
        return gathered
