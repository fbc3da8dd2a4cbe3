"""The stretching energy of edges as springs of relative elongation (paper, eq. 1).

E = k/2 (l / L - 1)^2,    l = |x1 - x0|, L the natural length.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class EdgeSprings:
    """Springs along edges, with their natural lengths.

    Parameters
    ----------
    nodes : (e, 2) array of int
        The two ends of each spring.
    stiffness : (e,) array of float
        k, J.
    natural_length : (e,) array of float
        L, m.
    """

    nodes: NDArray[np.int64]
    stiffness: Array
    natural_length: Array
    name: ClassVar[str] = "stretching"

    @cached_property
    def dofs(self) -> NDArray[np.int64]:
        """Coordinates of each spring's ends in the state, (e, 2, 3)."""
        return coordinates_of(self.nodes)

    @property
    def stencils(self) -> list[NDArray[np.int64]]:
        """The same, (e, 6); see `dshell.energies.assembly.Energy`."""
        return [self.dofs.reshape(-1, 6)]

    def at(self, state: Array) -> "_StretchedSprings":
        """Return the springs in a state; see `dshell.energies.assembly.Energy`."""
        return _StretchedSprings(self, state)


class _StretchedSprings:
    def __init__(self, springs: EdgeSprings, state: Array) -> None:
        self._springs = springs
        self._size = len(state)
        corners = state[springs.dofs]
        edge = corners[:, 1] - corners[:, 0]
        self._length = np.sqrt((edge * edge).sum(axis=1))
        self._along = edge / self._length[:, None]
        self._strain = self._length / springs.natural_length - 1
        self._tension = springs.stiffness * self._strain / springs.natural_length

    def energy(self) -> Array:
        """See `dshell.energies.assembly.Deformed`."""
        return 0.5 * self._springs.stiffness * self._strain**2

    def gradient(self) -> Array:
        """See `dshell.energies.assembly.Deformed`."""
        pull = (self._tension[:, None] * self._along)[:, None, :]
        return sum_at(self._springs.dofs, np.concatenate([-pull, pull], axis=1), self._size)

    def hessian(self) -> list[Array]:
        """See `dshell.energies.assembly.Deformed`."""
        return [self._stiffness(self._tension / self._length)]

    def convex_hessian(self) -> list[Array]:
        """Return the Hessian without the pressure of a short spring: no negative eigenvalue."""
        return [self._stiffness(np.maximum(self._tension, 0.0) / self._length)]

    def _stiffness(self, across: Array) -> Array:
        """Stiffness along the spring, and `across` for the directions in which it turns."""
        along = self._along
        stretching = self._springs.stiffness / self._springs.natural_length**2
        block = (stretching - across)[:, None, None] * (along[:, :, None] * along[:, None, :])
        block[:, range(3), range(3)] += across[:, None]
        return np.block([[block, -block], [-block, block]])
