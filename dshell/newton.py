"""Newton's method for the least energy: projected where the Hessian is indefinite, damped.

Each iteration factorises the exact Hessian; where that has a negative eigenvalue, its convex
relative instead, so that the step always goes downhill. Steps are capped in length and shortened
until the energy falls enough (Armijo).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from dshell.assembly import Assembly, Energy
from dshell.linear_solver import Factor, LinearSolver, SingularMatrixError

Array = NDArray[np.float64]

SUFFICIENT_DECREASE = 1e-4
SHORTEST_STEP = 1e-8
ROUND_OFF = 1e-14
"""Of the energy, relative: what a step may raise it by without meaning it."""


@dataclass(frozen=True, eq=False)
class Body:
    """What is in equilibrium: elastic energies under a dead load.

    Parameters
    ----------
    energies : sequence of Energy
        The elastic ones.
    load : array of float
        Force on each degree of freedom, N, in the shape of the state; it does not follow.
    """

    energies: Sequence[Energy]
    load: Array

    def potential(self, state: Array) -> tuple[float, float]:
        """Return the total energy, J, and the size of what adds up to it."""
        with np.errstate(all="ignore"):  # a step too far may invert a fibre; it is then refused
            parts = [term.energy(state[term.dofs]).sum() for term in self.energies]
        work = float(self.load @ state)
        return float(sum(parts)) - work, float(sum(map(abs, parts))) + abs(work)


@dataclass(frozen=True)
class NewtonLimits:
    """When an equilibrium is found or given up.

    Parameters
    ----------
    tolerance : float
        Norm of the residual force that is small enough, N.
    iterations : int
        Allowed in one solve.
    longest_step : float
        Largest change of a degree of freedom in one iteration, m.
    """

    tolerance: float
    iterations: int
    longest_step: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """Where the iterations ended.

    Parameters
    ----------
    state : array of float
        The last state.
    converged : bool
        Whether its residual is within the tolerance.
    residual : float
        Norm of the residual force on the free degrees of freedom, N.
    iterations : int
        Newton steps taken.
    """

    state: Array
    converged: bool
    residual: float
    iterations: int


class EquilibriumSolver:
    """Finds equilibria of bodies on one assembly.

    Parameters
    ----------
    assembly : Assembly
        Of the bodies' energies.
    linear_solver : LinearSolver
        For the steps.
    """

    def __init__(self, assembly: Assembly, linear_solver: LinearSolver) -> None:
        self.assembly = assembly
        self._linear = linear_solver

    def residual(self, body: Body, state: Array) -> Array:
        """Return the residual force on the free degrees of freedom, N."""
        return (self.assembly.gradient(body.energies, state) - body.load)[self.assembly.free]

    def settle(self, body: Body, start: Array, limits: NewtonLimits) -> Outcome:
        """Go downhill from a state to an equilibrium, or as far as the limits let."""
        state = start
        for iteration in range(limits.iterations + 1):
            residual = self.residual(body, state)
            error = float(np.linalg.norm(residual))
            if error <= limits.tolerance or iteration == limits.iterations:
                break
            step = np.zeros_like(state)
            step[self.assembly.free] = -self._descent(body, state).solve(residual)
            step *= min(1.0, limits.longest_step / np.abs(step).max())
            try:
                state = line_search(body, state, step, float(residual @ step[self.assembly.free]))
            except ComputationError:
                break
        return Outcome(state, error <= limits.tolerance, error, iteration)

    def unstable_modes(self, body: Body, state: Array) -> int:
        """Return the number of negative eigenvalues of the exact Hessian."""
        return self._exact(body, state).negative

    def _exact(self, body: Body, state: Array) -> Factor:
        return self._linear.factor(self.assembly.hessian(body.energies, state))

    def _descent(self, body: Body, state: Array) -> Factor:
        try:
            exact = self._exact(body, state)
            if exact.negative == 0:
                return exact
        except SingularMatrixError:
            pass
        return self._linear.factor(self.assembly.convex_hessian(body.energies, state))


def line_search(body: Body, state: Array, step: Array, slope: float) -> Array:
    """Return the state after the longest halved step that lowers the energy enough (Armijo).

    Raises
    ------
    ComputationError
        No step does.
    """
    here, size = body.potential(state)
    share = 1.0
    while share > SHORTEST_STEP:
        there, _ = body.potential(state + share * step)
        if there <= here + SUFFICIENT_DECREASE * share * slope + ROUND_OFF * size:
            return state + share * step
        share /= 2
    raise ComputationError("no step along Newton's direction lowers the energy")
