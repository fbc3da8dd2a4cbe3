"""Contact of a shell with itself or with obstacles: barriers of its skin, by the shell's state.

See `bilayer.contact.skin_map` for the skin and `bilayer.contact.barrier` for the barrier.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from bilayer.contact.several import SkinBarrier, SkinBarrierState
from bilayer.contact.skin_map import SkinMap

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SkinContact:
    """The contact of a shell.

    Parameters
    ----------
    skin : SkinMap
        The body's skin over the shell's surface.
    barrier : SkinBarrier
        Of that skin, against itself or anything else.
    nodes : int
        Nodes of the surface, whose coordinates the state begins with.
    """

    skin: SkinMap
    barrier: SkinBarrier
    nodes: int

    def at(self, state: Array) -> "TouchingSkin":
        """Return the contact in a state, (dofs,)."""
        return TouchingSkin(self, state)

    def points(self, state: Array) -> Array:
        """Return the points of the skin, m, (k, 3)."""
        return self.skin.points(self.surface(state))

    def surface(self, state: Array) -> Array:
        """Return the nodes of the surface, m, (n, 3)."""
        return state[: 3 * self.nodes].reshape(-1, 3)

    def free_share(self, start: Array, end: Array) -> float:
        """Return the share of the way between two states until the skin touches itself."""
        return self.barrier.free_share(self.points(start), self.points(end))

    def stays_apart(self, start: Array, end: Array) -> bool:
        """Whether no two places come within range on the way between two states."""
        return self.barrier.stays_clear(self.points(start), self.points(end))

    def is_crossed(self, state: Array) -> bool:
        """Whether the skin passes through itself."""
        return self.barrier.is_crossed(self.points(state))


class TouchingSkin:
    """The contact of a shell in one state.

    Parameters
    ----------
    contact : SkinContact
        Skin and barrier.
    state : (dofs,) array of float
        All degrees of freedom, m.
    """

    def __init__(self, contact: SkinContact, state: Array) -> None:
        self._contact, self._size = contact, len(state)
        self._surface = contact.surface(state)

    @cached_property
    def barrier(self) -> SkinBarrierState:
        """The barrier."""
        return self._contact.barrier.at(self._contact.skin.points(self._surface))

    @property
    def touches(self) -> bool:
        """Whether two places are within range."""
        return self.barrier.pairs > 0

    @property
    def energy(self) -> float:
        """J."""
        return self.barrier.energy

    @cached_property
    def gradient(self) -> Array:
        """Derivative of the energy by the state, N, (dofs,)."""
        forces = np.zeros(self._size)
        if self.touches:
            by_nodes = self._contact.skin.pull_back(self._surface, self.barrier.gradient)
            forces[: by_nodes.size] = by_nodes.reshape(-1)
        return forces

    def hessian(self) -> csr_matrix:
        """Return the second derivative by the nodes' coordinates, N/m, (3 n, 3 n)."""
        return self._pulled_back(self.barrier.gradient, self.barrier.hessian())

    def convex_hessian(self) -> csr_matrix:
        """Return the like of it without negative eigenvalues."""
        return self._pulled_back(np.zeros_like(self.barrier.points), self.barrier.convex_hessian())

    def _pulled_back(self, gradient: Array, hessian: csr_matrix) -> csr_matrix:
        return self._contact.skin.pull_back_hessian(self._surface, gradient, hessian)
