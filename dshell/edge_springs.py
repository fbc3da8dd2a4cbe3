"""The stretching energy of edges as springs of relative elongation (paper, eq. 1).

E = k/2 (l / L - 1)^2,    l = |x1 - x0|, L the natural length.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.assembly import coordinates_of

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

    @property
    def dofs(self) -> NDArray[np.int64]:
        """Coordinates of each spring's ends among all coordinates, shape (e, 2, 3)."""
        return coordinates_of(self.nodes)

    def energy(self, corners: Array) -> Array:
        """Return each spring's energy, J, shape (e,), from its ends' positions, (e, 2, 3) in m."""
        length, _ = _length_and_direction(corners)
        return 0.5 * self.stiffness * (length / self.natural_length - 1) ** 2

    def gradient(self, corners: Array) -> Array:
        """Return the derivative of the energy by the ends' positions, N, shape (e, 2, 3)."""
        length, along = _length_and_direction(corners)
        pull = (self._tension(length)[:, None] * along)[:, None, :]
        return np.concatenate([-pull, pull], axis=1)

    def hessian(self, corners: Array) -> Array:
        """Return the second derivative by the ends' positions, N/m, shape (e, 6, 6)."""
        length, along = _length_and_direction(corners)
        return self._stiffness(along, self._tension(length) / length)

    def convex_hessian(self, corners: Array) -> Array:
        """Return the Hessian without the pressure of a short spring: no negative eigenvalue."""
        length, along = _length_and_direction(corners)
        return self._stiffness(along, np.maximum(self._tension(length), 0.0) / length)

    def _stiffness(self, along: Array, across: Array) -> Array:
        """Stiffness along the spring, and `across` for the directions in which it turns."""
        block = (self.stiffness / self.natural_length**2 - across)[:, None, None] * (
            along[:, :, None] * along[:, None, :]
        )
        block[:, range(3), range(3)] += across[:, None]
        return np.block([[block, -block], [-block, block]])

    def _tension(self, length: Array) -> Array:
        return self.stiffness * (length / self.natural_length - 1) / self.natural_length


def _length_and_direction(corners: Array) -> tuple[Array, Array]:
    edge = corners[:, 1] - corners[:, 0]
    length = np.sqrt((edge * edge).sum(axis=1))
    return length, edge / length[:, None]
