"""Forces and springs at single degrees of freedom of the solid, beside its forms.

    energy = sum over dofs of  k / 2 (u - w)^2 - f u,

u a displacement component. A spring that is stiff imposes its goal w, as a testing machine does;
the force in it is exactly that of an equilibrium. UFL has no integrals over points, so these terms
are added to the assembled residual and to the diagonal of the tangent.
"""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class NodalForce:
    """A dead force: so much at each of some dofs for a value of 1."""

    dofs: NDArray[np.int64]
    shares: Array


class NodalTerms:
    """The forces and springs that act now, at the dofs that this rank owns.

    Parameters
    ----------
    owned : int
        Number of these dofs.
    comm : MPI.Comm
        The ranks.
    """

    def __init__(self, owned: int, comm: MPI.Comm) -> None:
        self._comm = comm
        self._force, self.stiffness, self._pull = (np.zeros(owned) for _ in range(3))

    def clear(self) -> None:
        """Let nothing act."""
        for array in (self._force, self.stiffness, self._pull):
            array[:] = 0.0

    def push(self, force: NodalForce, value: float) -> None:
        """Add a dead force."""
        np.add.at(self._force, force.dofs, value * force.shares)

    def grip(self, dofs: NDArray[np.int64], stiffness: float, goal: float) -> None:
        """Add springs, N/m, with a goal, m."""
        self.stiffness[dofs] += stiffness
        self._pull[dofs] += stiffness * goal

    @property
    def is_idle(self) -> bool:
        """Whether nothing acts on this rank."""
        return not (self._force.any() or self.stiffness.any())

    def gradient(self, values: Array) -> Array:
        """Return the derivative of the energy at dofs of a state, N, those owned alone."""
        return np.asarray(self.stiffness * values[: len(self.stiffness)] - self._pull - self._force)

    def energy(self, values: Array) -> float:
        """Return the energy, J, but for a constant, the same on every rank."""
        u = values[: len(self.stiffness)]
        local = float(np.sum((self.stiffness * u / 2 - self._pull - self._force) * u))
        return float(self._comm.allreduce(local, op=MPI.SUM))

    def work(self, force: NodalForce, values: Array) -> float:
        """Return the displacement along a force, times its shares, the same on every rank."""
        local = float(np.sum(force.shares * values[force.dofs]))
        return float(self._comm.allreduce(local, op=MPI.SUM))

    def total(self, parts: Array) -> float:
        """Return the sum of numbers of all ranks."""
        return float(self._comm.allreduce(float(np.sum(parts)), op=MPI.SUM))
