"""A walk off an unstable equilibrium: along its mode, everything else in balance.

The energy is minimised with the distance along a direction d held at a, that is

    R(x) = s M d,   d . M (x - x0) = a (d . M d),

by Newton's method on the bordered system: the factors of the tangent and two right-hand sides
(W. Wagner, P. Wriggers, Engineering Computations 5 (1988) 103-109). Without the soft direction that
is well posed, also where the tangent is singular. The multiplier s is the slope of the energy along
the walk: it is negative on the way down, and zero at the next equilibrium.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_model.solid.state import State
from fenics_model.solve.newton import Newton

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WalkRule:
    """Distances of a walk, and when it ends.

    Parameters
    ----------
    growth, cut : float
        Factors of the step after a success and after a failure.
    farthest : float
        Over the first distance: where a walk that still leads down is given up.
    iteration_limit : int
        Iterations at a place after which it has failed.
    cuts : int
        Failed places after which the walk ends. The valley may turn away from the straight
        direction; then there is no place farther out.
    accuracy : float
        The residual that is left, over the force that holds the distance.
    """

    growth: float = 2.0
    cut: float = 4.0
    farthest: float = 2000.0
    iteration_limit: int = 8
    cuts: int = 1
    accuracy: float = 1e-3


@dataclass(frozen=True, eq=False)
class WalkOutcome:
    """The end of a walk.

    Parameters
    ----------
    state : State
        Near where the energy is least, or the lowest place on the way.
    arrived : bool
        Whether the energy rises again there.
    iterations : int
        Factorisations.
    """

    state: State
    arrived: bool
    iterations: int


@dataclass(frozen=True, eq=False)
class _Place:
    """The minimum of the energy at a distance: the state, and its derivative by the distance."""

    distance: float
    state: State
    tangent: Array
    slope: float


class ValleyWalk:
    """Walks down from an unstable equilibrium.

    Parameters
    ----------
    newton : Newton
        Solves.
    origin : State
        The equilibrium.
    direction : array of float
        d, a change of it.
    tolerance : float
        Norm of the residual of an equilibrium, N; no place is solved more accurately.
    rule : WalkRule
        Its steps.
    """

    def __init__(
        self, newton: Newton, origin: State, direction: Array, tolerance: float, rule: WalkRule
    ) -> None:
        self._newton, self._dot, self._norm = newton, newton.layout.dot, newton.layout.norm
        self._tolerance, self._rule = tolerance, rule
        self._force = newton.mass.times(direction)
        self._square = self._dot(self._force, direction)
        self._start = _Place(0.0, origin, direction, 0.0)
        self._iterations = 0

    def descend(self, first_distance: float) -> WalkOutcome:
        """Walk down until the energy rises again."""
        here, step, cuts = self._start, first_distance, 0
        while here.distance < self._rule.farthest * first_distance and cuts <= self._rule.cuts:
            there = self._place(here, here.distance + step)
            if there is None:
                step, cuts = step / self._rule.cut, cuts + 1
                continue
            if there.slope > 0:
                return WalkOutcome(_between(here, there), True, self._iterations)
            here, step = there, self._rule.growth * step
        return WalkOutcome(here.state, False, self._iterations)

    def _place(self, here: _Place, distance: float) -> _Place | None:
        """Solve at a distance, from the tangent at another place; None if that fails."""
        state = here.state + (distance - here.distance) * here.tangent
        for _ in range(self._rule.iteration_limit):
            found = self._improve(state, distance)
            if found is None:
                return None
            left, accepted = self._balance(found)
            if left <= accepted:
                return found
            if not np.isfinite(left):
                return None
            state = found.state
        return None

    def _improve(self, state: State, distance: float) -> _Place | None:
        """Return a guess after one iteration; None if its tangent has no factors."""
        self._iterations += 1
        with self._newton.factorise(state) as factors:
            if factors.failure:
                return None
            elastic = factors.solve(self._newton.residual(state))
            held = factors.solve(self._force)
        off = state - self._start.state
        gap = distance * self._square - self._dot(self._force, off)
        compliance = self._dot(self._force, held)
        slope = (gap + self._dot(self._force, elastic)) / compliance
        tangent = held * (self._square / compliance)
        return _Place(distance, state + (slope * held - elastic), tangent, slope)

    def _balance(self, place: _Place) -> tuple[float, float]:
        """Return the norm of the residual that is left, and what is accepted, N."""
        left = self._newton.residual(place.state) - place.slope * self._force
        holding = abs(place.slope) * self._norm(self._force)
        return self._norm(left), max(self._tolerance, self._rule.accuracy * holding)


def _between(before: _Place, after: _Place) -> State:
    """Guess the state where the slope is zero: cubic Hermite interpolation between two places."""
    span = after.distance - before.distance
    share = before.slope / (before.slope - after.slope)
    return before.state + (
        share**2 * (3 - 2 * share) * (after.state - before.state)
        + share * (1 - share) ** 2 * span * before.tangent
        + share**2 * (share - 1) * span * after.tangent
    )
