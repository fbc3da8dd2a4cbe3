"""Newton's method for the least energy: projected where the Hessian is indefinite, damped.

Each iteration factorises the exact Hessian; where that has a negative eigenvalue, its convex
relative instead, so that the step always goes downhill. Steps are capped in length and shortened
until the energy falls enough (Armijo).

A thin shell bends easily and stretches hardly, so a straight step that turns it also stretches it,
and the line search would allow only short ones (the Maratos effect). Corrections with the same
factor, shortened where in full they would raise the energy, take that stretch away again before the
energy is judged: they cost no factorisation.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import ArpackError, LinearOperator, eigsh

from bilayer.errors import ComputationError
from dshell.assembly import Assembly, Energy
from dshell.linear_solver import Factor, LinearSolver, NotPositiveDefiniteError, SingularMatrixError

Array = NDArray[np.float64]

SUFFICIENT_DECREASE = 1e-4
SHORTEST_STEP = 1e-8
CONVEX_SHIFT = 1e-8
"""Of the mean diagonal: keeps a convex relative regular where nothing resists."""
FEW_NEGATIVE = 3
"""Negative eigenvalues whose modes are sought: far from an equilibrium there are many."""
MODE_TOLERANCE = 1e-4
MODE_RESTARTS = 3
"""Of ARPACK, twenty solutions each, for modes that mend a stiffness: those worth it, nearly 0,
stand apart and take no more; others took thousands of solutions on a fine mesh."""
CORRECTIONS = 4
"""With one factor; `scripts/benchmark dshell` tells the iterations that they leave."""
CORRECTION_SHARES = (1.0, 0.5, 0.25)
"""Of a correction, tried in this order until the energy falls."""
ENERGY_NOISE = 1e-6
"""Relative. Smaller changes may be round-off (strains of 1e-5 leave the energy six digits), so
there the residual force is the judge."""


class NoDescentError(ComputationError):
    """No step along Newton's direction lowers the energy."""


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


class _Mended:
    """An indefinite matrix, factorised, with its negative eigenvalues' signs turned."""

    def __init__(self, factor: Factor, values: Array, modes: Array) -> None:
        self._factor, self._values, self._modes = factor, values, modes

    def solve(self, right_side: Array) -> Array:
        """See `Factor`."""
        along = np.divide(self._modes.T @ right_side, self._values)
        return self._factor.solve(right_side) - 2 * self._modes @ along


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

    def settle(self, bodies: Sequence[Body], start: Array, limits: NewtonLimits) -> Outcome:
        """Go downhill from a state to an equilibrium, or as far as the limits let.

        Parameters
        ----------
        bodies : sequence of Body
            What is on its way to the last of them: each of the others gets one iteration.
        start : array of float
            The first state, m.
        limits : NewtonLimits
            When to stop.
        """
        state = start
        for iteration in range(limits.iterations + 1):
            body = bodies[min(iteration, len(bodies) - 1)]
            residual = self.residual(body, state)
            error = float(np.linalg.norm(residual))
            converged = body is bodies[-1] and error <= limits.tolerance
            if converged or iteration == limits.iterations:
                break
            try:
                state = self._improved(body, state, residual, limits.longest_step)
            except NoDescentError:
                break
        return Outcome(state, converged, error, iteration)

    def balance(self, body: Body, start: Array, limits: NewtonLimits) -> Outcome:
        """Go to an equilibrium near a state, stable or not, by plain Newton steps, capped alone.

        Parameters
        ----------
        body : Body
            What is in equilibrium.
        start : array of float
            The first state, m.
        limits : NewtonLimits
            When to stop.
        """
        state = start
        for iteration in range(limits.iterations + 1):
            residual = self.residual(body, state)
            error = float(np.linalg.norm(residual))
            converged = error <= limits.tolerance
            if converged or not np.isfinite(error) or iteration == limits.iterations:
                break
            hessian = self.assembly.hessian(body.energies, state)
            try:
                factor = self._linear.factor(hessian)
            except SingularMatrixError:
                break
            state = state + self._step(factor, residual, limits.longest_step)
        return Outcome(state, converged, error, iteration)

    def unstable_modes(self, body: Body, state: Array) -> int:
        """Return the number of negative eigenvalues of the exact Hessian."""
        hessian = self.assembly.hessian(body.energies, state)
        try:
            self._linear.cholesky(hessian)
        except NotPositiveDefiniteError:
            return self._linear.factor(hessian).negative
        return 0

    def unstable_direction(self, body: Body, state: Array) -> Array:
        """Return the direction of the negative eigenvalue nearest to 0, its largest entry 1."""
        hessian = self.assembly.hessian(body.energies, state)
        _, modes = _negative_pairs(hessian, self._linear.factor(hessian), count=1)
        direction = np.zeros_like(state)
        direction[self.assembly.free] = modes[:, 0]
        return direction / direction[np.argmax(np.abs(direction))]

    def _improved(self, body: Body, state: Array, residual: Array, longest: float) -> Array:
        """Return the state after one iteration: the longest halved step that is low enough."""
        factor = self._descent(body, state)
        step = self._step(factor, residual, longest)
        slope = float(residual @ step[self.assembly.free])
        here, size = body.potential(state)
        share = 1.0
        while share > SHORTEST_STEP:
            there, energy = self._corrected(body, state + share * step, factor, longest)
            if energy <= here + SUFFICIENT_DECREASE * share * slope:
                return there
            if abs(energy - here) <= ENERGY_NOISE * size and self._is_nearer(body, there, residual):
                return there
            share /= 2
        raise NoDescentError("no step along Newton's direction lowers the energy")

    def _is_nearer(self, body: Body, state: Array, residual: Array) -> bool:
        """Whether the residual force at a state is less than half of another."""
        return bool(np.linalg.norm(self.residual(body, state)) < 0.5 * np.linalg.norm(residual))

    def _corrected(
        self, body: Body, state: Array, factor: Factor, longest: float
    ) -> tuple[Array, float]:
        """Return a state with its energy after those corrections that lower it."""
        energy, _ = body.potential(state)
        for _ in range(CORRECTIONS):
            if not np.isfinite(energy):
                break
            correction = self._step(factor, self.residual(body, state), longest)
            lower = _lower(body, state, correction, energy)
            if lower is None:
                break
            state, energy = lower
        return state, energy

    def _step(self, factor: Factor, residual: Array, longest: float) -> Array:
        step = np.zeros(self.assembly.size)
        step[self.assembly.free] = -factor.solve(residual)
        return step * min(1.0, longest / max(np.abs(step).max(), longest))

    def _descent(self, body: Body, state: Array) -> Factor:
        hessian = self.assembly.hessian(body.energies, state)
        try:
            return self._linear.cholesky(hessian)
        except NotPositiveDefiniteError:
            return self._mended(hessian) or self._convex(body, state)

    def _mended(self, hessian: csc_matrix) -> Factor | None:
        """Return the Hessian with its negative eigenvalues made positive, if they are few.

        Where a shape is about to lose its symmetry one or two of them are nearly 0, and the convex
        relative, which resists there, would only crawl.
        """
        try:
            factor = self._linear.factor(hessian)
            if 0 < factor.negative <= FEW_NEGATIVE:
                pairs = _negative_pairs(hessian, factor, factor.negative, MODE_RESTARTS)
                return _Mended(factor, *pairs)
        except (SingularMatrixError, ArpackError):
            pass
        return None

    def _convex(self, body: Body, state: Array) -> Factor:
        convex = self.assembly.convex_hessian(body.energies, state)
        diagonal = convex.diagonal()
        convex.setdiag(diagonal + CONVEX_SHIFT * diagonal.mean())
        try:
            return self._linear.cholesky(convex)
        except NotPositiveDefiniteError as error:
            raise NoDescentError("round-off hides the convex relative of the stiffness") from error


def _negative_pairs(
    matrix: csc_matrix, factor: Factor, count: int, restarts: int | None = None
) -> tuple[Array, Array]:
    """Return the negative eigenvalues nearest to 0, (count,), and their modes, (n, count)."""
    size = matrix.shape[0]
    inverse = LinearOperator((size, size), matvec=factor.solve, dtype=float)
    begin = np.random.default_rng(0).normal(size=size)
    values, modes = eigsh(
        matrix, k=count, sigma=0.0, OPinv=inverse, which="SA", v0=begin, tol=MODE_TOLERANCE,
        maxiter=restarts,
    )  # fmt: skip
    return values, modes


def _lower(
    body: Body, state: Array, correction: Array, energy: float
) -> tuple[Array, float] | None:
    """Return the state after the largest share of a correction that lowers the energy, with it."""
    for share in CORRECTION_SHARES:
        there = state + share * correction
        lower, _ = body.potential(there)
        if lower < energy:
            return there, lower
    return None
