"""Grips: springs that hold nodes at a place along one direction, as a testing machine does.

    energy = k / 2 (u . d - w)^2   for each node,

u its displacement from the flat state, d the direction, w the imposed displacement. The force k
(w - u . d) is that of the sheet on the machine, exactly, however stiff the springs are: a state in
which they are in balance is an equilibrium of the sheet under that force, and one that is stable
with them may be unstable under the force alone. So they lead past limit points.
"""

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at

Array = NDArray[np.float64]


class Grips:
    """Springs at nodes.

    Parameters
    ----------
    places : (n, 3) array of float
        Flat places of all nodes, m.
    nodes : (k,) array of int
        Those that are held.
    direction : (3,) array of float
        A unit vector.
    stiffness : float
        Of each spring, N/m; 0: nothing is held.
    displacement : float
        m.
    """

    name: ClassVar[str] = "grips"

    def __init__(
        self,
        places: Array,
        nodes: NDArray[np.int64],
        direction: Array,
        stiffness: float,
        displacement: float,
    ) -> None:
        self.direction, self.stiffness = np.asarray(direction), stiffness
        self.goal = places[nodes] @ self.direction + displacement
        self.dofs = coordinates_of(nodes)
        self.stencils = [self.dofs]

    def force(self, state: Array) -> float:
        """Return the sum of the forces on the nodes, along the direction, N."""
        return float(-self.stiffness * self.excess(state).sum())

    def excess(self, state: Array) -> Array:
        """Return how far each node is beyond its goal along the direction, m."""
        return np.asarray(state[self.dofs] @ self.direction - self.goal)

    def at(self, state: Array) -> "HeldGrips":
        """Return the springs in a state; see `dshell.energies.assembly.Energy`."""
        return HeldGrips(self, state)


class HeldGrips:
    """Springs in some state."""

    def __init__(self, grips: Grips, state: Array) -> None:
        self._grips, self._size = grips, len(state)
        self._excess = grips.excess(state)

    def energy(self) -> Array:
        """Return the energy of each spring, J."""
        return np.asarray(self._grips.stiffness / 2 * self._excess**2)

    def gradient(self) -> Array:
        """Return the derivative by the state, N."""
        pull = self._grips.stiffness * np.multiply.outer(self._excess, self._grips.direction)
        return sum_at(self._grips.dofs, pull, self._size)

    def hessian(self) -> list[Array]:
        """Return the second derivative, N/m, (k, 3, 3)."""
        one = self._grips.stiffness * np.multiply.outer(
            self._grips.direction, self._grips.direction
        )
        return [np.tile(one, (len(self._excess), 1, 1))]

    def convex_hessian(self) -> list[Array]:
        """Return the second derivative, which is convex."""
        return self.hessian()
