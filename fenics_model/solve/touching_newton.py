"""Newton's method for a solid whose skin may touch itself or obstacles, and passes through nothing.

1. It is solved as if nothing new touched: the places that press on each other where the body sets
   out are held together by springs, their barriers linearised. Before the first contact there are
   none. If the skin then is clear of itself on the straight way to the solution, that is all.
2. The body goes from where it sets out toward that solution, as far as its skin lets it: the least
   of the energy, linearised there, and of the barrier. This leaves what bends to the first part,
   and what touches to the second.
3. Newton's method from there. Its steps are shortened until nothing is passed through, and to the
   least of energy and barrier along them, with the energy linearised: along a straight step the
   true one rises with the square of it, because what bends by straight steps also stretches.

A new tangent is taken for each step, because its pairs change. Far from the solution the negative
eigenvalues of each pair are left out; near to it only if the tangent shows unstable modes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from dolfinx import fem
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.runtime.termination import PutOff, signals_put_off
from fenics_model.contact.barrier_force import (
    BarrierForce,
    ConvexBarrierForce,
    LinearisedBarrierForce,
)
from fenics_model.contact.surface_contact import SurfaceContact
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State
from fenics_model.solve.corrections import CorrectionRule
from fenics_model.solve.factors import Factors
from fenics_model.solve.layout import Layout
from fenics_model.solve.newton import INSIDE_OUT, Newton, NewtonOutcome

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TouchingRule:
    """Limits of a solution in contact.

    Parameters
    ----------
    rough : float
        Residual of the solution with linearised barriers, over their force.
    approaches : int
        Steps toward it.
    arrived : float
        Length of a step over the whole way, below which no further one is taken.
    iteration_limit : int
        Steps of Newton's method from there, after which it has failed.
    free_share : float
        Of the step to the next contact, the share that is taken at most.
    flat : float
        Slope at the end of a step over that at its beginning, up to which it is not shortened.
    searches : int
        Places along a step that are looked at.
    halvings : int
        How often a step is halved that turns an element inside out.
    """

    rough: float = 1e-2
    approaches: int = 5
    arrived: float = 0.02
    iteration_limit: int = 25
    free_share: float = 0.9
    flat: float = 0.1
    searches: int = 12
    halvings: int = 8


@dataclass(frozen=True, eq=False)
class LinearForce:
    """The residual of everything but contact, linearised at a state.

    Parameters
    ----------
    origin : State
        Where.
    residual : array of float
        There, N.
    tangent : PETSc Mat
        Its derivative, N/m.
    layout : Layout
        Of the dofs.
    """

    origin: State
    residual: Array
    tangent: PETSc.Mat
    layout: Layout

    def at(self, state: State) -> Array:
        """Return it at another state."""
        return self.residual + self.along(state - self.origin)

    def along(self, change: Array) -> Array:
        """Return what it changes by."""
        return self.layout.times(self.tangent, change)


class TouchingNewton(Newton):
    """Finds states of a solid that its skin can come to without passing through anything.

    Parameters
    ----------
    solid, held
        As for `Newton`.
    contact : SurfaceContact
        Of the solid.
    limits : TouchingRule, optional
        Of solutions in contact.
    **others
        As for `Newton`.
    """

    def __init__(
        self,
        solid: Solid,
        held: Sequence[fem.DirichletBC],
        contact: SurfaceContact,
        *,
        limits: TouchingRule | None = None,
        **others: object,
    ) -> None:
        super().__init__(solid, held, **others)  # type: ignore[arg-type]
        self._contact, self._limits = contact, TouchingRule() if limits is None else limits
        self._exact, self._convex = BarrierForce(contact), ConvexBarrierForce(contact)
        self._added = self._exact
        self._here = solid.undeformed

    def set_out_from(self, state: State) -> None:
        """See `Newton`."""
        self._here = state

    def reach(self, start: State, end: State) -> State:
        """See `Newton`; short of what its skin would pass through."""
        free = self._contact.free_share(start, end)
        return end if free == 1.0 else start + self._limits.free_share * free * (end - start)

    def passes_through(self, state: State) -> bool:
        """See `Newton`."""
        return self._contact.barrier.is_crossed(self._contact.points(state))

    def touches(self, state: State) -> bool:
        """See `Newton`."""
        return self._contact.at(state).pairs > 0

    def solve(
        self,
        guess: State,
        tolerance: float,
        factors: Factors | None = None,
        *,
        iteration_limit: int | None = None,
        rule: CorrectionRule | None = None,
    ) -> NewtonOutcome:
        """See `Newton`. The body sets out from the last solution, or from where it was told.

        With factors it sets out from the guess, where they were made, and stops short of what its
        skin would pass through.
        """
        if factors is not None:
            return self._stop_short(guess, super().solve(
                guess, tolerance, factors, iteration_limit=iteration_limit, rule=rule
            ))  # fmt: skip
        springs, accepted = None, tolerance
        if self.touches(self._here):
            springs = LinearisedBarrierForce(self._contact, self._here)
            pressing = self.layout.norm(springs.force(self._here))
            accepted = max(tolerance, self._limits.rough * pressing)
        with self._with_force(springs):
            found = super().solve(guess, accepted, iteration_limit=iteration_limit, rule=rule)
        if found.converged and not (springs is None and self._is_clear_to(found.state)):
            found = self._solve_apart(found, tolerance)
        if found.converged:
            self._here = found.state
        return found

    def potential_energy(self, state: State) -> float:
        """See `Newton`; with the barrier's."""
        return super().potential_energy(state) + self._contact.at(state).energy

    def _stop_short(self, start: State, found: NewtonOutcome) -> NewtonOutcome:
        """Return the outcome, or its last state that can be come to on a straight way."""
        state = self.reach(start, found.state)
        if state is found.state:
            return found
        return replace(
            found,
            state=state,
            converged=False,
            residual=self._norm_at(state),
            reason="the skin would pass through itself",
        )

    def _is_clear_to(self, state: State) -> bool:
        """Whether a solution without contact is one with it, and can be come to."""
        if self._contact.stays_clear(self._here, state):
            return True
        return not self.touches(state) and self._contact.free_share(self._here, state) == 1.0

    def _solve_apart(self, aim: NewtonOutcome, tolerance: float) -> NewtonOutcome:
        """Solve from where the body sets out, given a solution that its skin may not come to."""
        with signals_put_off() as signals, self.stopwatch.time_solution():
            begin, steps = self._approach(aim.state)
            found = self._iterate_apart(begin, tolerance, signals)
        return replace(
            found,
            iterations=aim.iterations + steps + found.iterations,
            corrections=aim.corrections + steps + found.corrections,
        )

    def _approach(self, aim: State) -> tuple[State, int]:
        """Go toward a state as far as the skin allows; return also the number of steps."""
        limits, norm = self._limits, self.layout.norm
        self.solid.tangent.reset_extrapolation()
        model = self._linearise(aim)
        here, whole = self._here, norm(aim - self._here)
        for count in range(limits.approaches):
            self._tell(f"approach to contact, step {count + 1}")
            factors = self._factorise_with(self._convex, here)
            if factors.failure:
                return here, count
            before, here = here, here + self._step(model, here, factors)
            if norm(here - before) < limits.arrived * whole:
                return here, count + 1
        return here, limits.approaches

    def _iterate_apart(self, here: State, tolerance: float, signals: PutOff) -> NewtonOutcome:
        """Iterate from a state that passes through nothing."""
        iterations, steps, length, reason, is_near = 0, 0, np.inf, "", False
        self.solid.tangent.reset_extrapolation()
        norm = self._norm_at(here)
        while norm > tolerance and not reason:
            if iterations >= self._limits.iteration_limit:
                reason = "too many iterations in contact"
                break
            self._tell(f"contact, iteration {iterations + 1}, residual {norm / tolerance:.1e} of "
                       "what is accepted")  # fmt: skip
            model = self._linearise(here)
            factors, count = self._factorise_apart(here, is_near)
            iterations, steps = iterations + count, steps + 1
            if factors.failure:
                reason = factors.failure
                break
            there = self._sound_state(here, self._step(model, here, factors))
            if there is None:
                reason = INSIDE_OUT
                break
            moved = self._contact.points(there) - self._contact.points(here)
            is_near = bool(np.abs(moved).max() < self._contact.barrier.range)
            length, here = self.layout.norm(there - here), there
            norm = self._norm_at(here)
            if self._is_interrupted(signals):
                reason = "interrupted"
        return NewtonOutcome(here, not reason, iterations, steps, norm, length, reason)

    def _norm_at(self, state: State) -> float:
        return self.layout.norm(self.slowed_residual(state))

    def _linearise(self, state: State) -> LinearForce:
        """Linearise everything but contact at a state; its tangent is in the solver's matrix."""
        with self._with_force(None):
            residual = self.slowed_residual(state)
        self._assemble_tangent(self._matrix)
        return LinearForce(State(self.solid.unknown.x.array), residual, self._matrix, self.layout)

    def _factorise_apart(self, here: State, is_near: bool) -> tuple[Factors, int]:
        """Factorise the tangent that was assembled last, with contact; how often that was done."""
        if is_near:
            factors, pressures = (
                self._factorise_with(self._exact, here),
                self.solid.number_of_pressures,
            )
            if (factors.negative_pivots or pressures) <= pressures:
                return factors, 1
        return self._factorise_with(self._convex, here), 1 + is_near

    def _step(self, model: LinearForce, here: State, factors: Factors) -> Array:
        """Return the step of Newton's method, shortened as far as contact asks for it."""

        def pressed(state: State) -> Array:
            return self._free_part(self._exact.force(state))

        elastic = model.at(here)
        step = -factors.solve(elastic + pressed(here))
        self.stopwatch.count_correction()
        slope, bend = (self.layout.dot(each, step) for each in (elastic, model.along(step)))

        def slope_at(share: float) -> float:
            there = pressed(here + share * step)
            return slope + share * bend + self.layout.dot(there, step)

        free = self._contact.free_share(here, here + step)
        longest = 1.0 if free == 1.0 else self._limits.free_share * free
        return step * share_of_least(slope_at, longest, self._limits.flat, self._limits.searches)

    def _sound_state(self, here: State, step: Array) -> State | None:
        """Return the state after a step, halved until the residual is a number; None: never."""
        for _ in range(self._limits.halvings + 1):
            if math.isfinite(self._norm_at(here + step)):
                return here + step
            step = step / 2
        return None


def share_of_least(
    slope_at: Callable[[float], float], longest: float, flat: float, searches: int
) -> float:
    """Return where a function of one variable is nearly least between 0 and `longest`.

    By false position on its slope, each end weighed down while the other one stays (Illinois).

    Parameters
    ----------
    slope_at : callable
        The slope, negative at 0.
    longest : float
        The end.
    flat : float
        Slope over that at 0 which is small enough.
    searches : int
        Places that are looked at at most.

    Examples
    --------
    >>> share_of_least(lambda s: s - 0.25, 1.0, 1e-6, 12)
    0.25
    >>> share_of_least(lambda s: s - 2, 1.0, 1e-6, 12)
    1.0
    """
    low, high = (0.0, slope_at(0.0)), (longest, slope_at(longest))
    enough = flat * abs(low[1])
    if high[1] <= enough or low[1] >= 0:
        return longest
    weights, share = [1.0, 1.0], longest
    for _ in range(searches):
        below, above = low[1] * weights[0], high[1] * weights[1]
        share = (low[0] * above - high[0] * below) / (above - below)
        slope = slope_at(share)
        if abs(slope) <= enough:
            break
        if slope > 0:
            high, weights = (share, slope), [weights[0] / 2, 1.0]
        else:
            low, weights = (share, slope), [1.0, weights[1] / 2]
    return share
