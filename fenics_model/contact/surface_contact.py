"""Contact of the solid: the barrier of its skin as a force and a stiffness of its dofs.

The skin is gathered, and every rank looks at the whole of it. So all ranks find the same pairs, and
the result is that of one rank. Each adds what belongs to the dofs that it owns.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc
from scipy.sparse import coo_matrix, csr_matrix

from bilayer.contact.several import SkinBarrier, SkinBarrierState
from fenics_model.contact.solid_skin import SolidSkin
from fenics_model.solid.numbering import Numbering
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LATEST = 2
"""States whose contact is kept for the next question."""


class SurfaceContact:
    """The contact of a solid with itself, or with anything else.

    Parameters
    ----------
    solid : Solid
        Which touches.
    skin : SolidSkin
        Of the solid.
    barrier : SkinBarrier
        Of that skin.
    """

    def __init__(self, solid: Solid, skin: SolidSkin, barrier: SkinBarrier) -> None:
        self.skin, self.barrier = skin, barrier
        self._comm, self._space = solid.mesh.mesh.comm, solid.space
        self._mine, self._slots = _skin_dofs(Numbering(solid), skin)
        self._latest: list[tuple[State, SkinBarrierState]] = []

    def points(self, state: State) -> Array:
        """Return the points of the skin, m, (k, 3), the same on every rank."""
        moved = self._gathered(state.values[self._mine])
        return self.skin.flat + moved.reshape(-1, 3)

    def at(self, state: State) -> SkinBarrierState:
        """Return the barrier in a state."""
        for known, found in self._latest:
            if known is state or np.array_equal(known.values, state.values):
                return found
        found = self.barrier.at(self.points(state))
        self._latest = [(state, found), *self._latest[: LATEST - 1]]
        return found

    def free_share(self, start: State, end: State) -> float:
        """Return the share of the way between two states until the skin touches."""
        return self.barrier.free_share(self.points(start), self.points(end))

    def stays_clear(self, start: State, end: State) -> bool:
        """Whether nothing comes within range on the way between two states."""
        return self.barrier.stays_clear(self.points(start), self.points(end))

    def by_dofs(self, state: State, gradient: Array) -> Array:
        """Return a gradient by the points, (k, 3), as one by the dofs that this rank owns."""
        force = np.zeros_like(state.values)
        force[self._mine] = gradient.reshape(-1)[self._slots]
        return force

    def stiffness(self, hessian: csr_matrix, held: NDArray[np.int32]) -> PETSc.Mat:
        """Return a second derivative by the points as one by the dofs; the caller destroys it.

        Parameters
        ----------
        hessian : (3 k, 3 k) sparse matrix
            By the points, N/m.
        held : array of int
            Dofs of this rank that are held: they are left out.
        """
        is_free = self._gathered(np.isin(self._mine, held, invert=True).astype(float)) > 0
        found = hessian.tocoo()
        row = self._own_row[found.row]
        kept = (row >= 0) & is_free[found.row] & is_free[found.col]
        dofs = self._space.dofmap
        owned, every = (
            size * dofs.index_map_bs
            for size in (dofs.index_map.size_local, dofs.index_map.size_global)
        )
        column = self._column[found.col[kept]]
        local = coo_matrix((found.data[kept], (row[kept], column)), shape=(owned, every)).tocsr()
        local.sort_indices()
        parts = [a.astype(PETSc.IntType) for a in (local.indptr, local.indices)]
        sizes = (owned, every)
        return PETSc.Mat().createAIJ((sizes, sizes), csr=(*parts, local.data), comm=self._comm)

    def _gathered(self, mine: Array) -> Array:
        """Return a value for each coordinate of the points, given those of this rank."""
        everywhere = np.empty(self.skin.flat.size)
        for slots, values in self._comm.allgather((self._slots, mine)):
            everywhere[slots] = values
        return everywhere

    @cached_property
    def _own_row(self) -> Indices:
        """The dof of each coordinate of the points on this rank; -1 if another one owns it."""
        row = np.full(self.skin.flat.size, -1)
        row[self._slots] = self._mine
        return row

    @cached_property
    def _column(self) -> Indices:
        """PETSc's number of each coordinate of the points."""
        dofs = self._space.dofmap
        first = dofs.index_map.local_range[0] * dofs.index_map_bs
        return self._gathered((first + self._mine).astype(float)).astype(np.int64)


def _skin_dofs(numbering: Numbering, skin: SolidSkin) -> tuple[Indices, Indices]:
    """Return the dofs that this rank owns on the skin, and the coordinates that they are."""
    slot = np.full(numbering.size, -1)
    slot[3 * skin.node[:, None] + np.arange(3)] = np.arange(skin.flat.size).reshape(-1, 3)
    own = slot[numbering.number[: numbering.owned]]
    mine = np.flatnonzero(own >= 0)
    return mine, own[mine]
