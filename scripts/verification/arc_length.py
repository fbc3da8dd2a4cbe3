"""A path of equilibria under one force, through its limit points: arc length in the plane of two.

Newton's method takes the force as one more unknown. The equation that is added keeps each iterate
on the line across the last chord of the curve of the force over the deflection under it (Riks,
Int. J. Solids Struct. 15, 529, 1979). So it passes where the force has its largest or least value,
and where the deflection has.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError

Array = NDArray[np.float64]
State = TypeVar("State")
SHORTEST = 1 / 64
"""Of a step, the least part that is tried."""
SHARPEST_TURN = 0.5
"""Cosine of the angle between two steps: a larger one may be the way back."""
MOST_STEPS = 1000
"""Tried on one path."""


class Loaded(Protocol[State]):
    """A body under a force that grows."""

    def residual(self, state: State, force: float) -> Array:
        """Return the residual of a state under a force, N."""

    def solve(self, state: State, *right_sides: Array) -> list[Array]:
        """Return the solutions with the tangent of a state, m."""

    def unit_force(self) -> Array:
        """Return the force of 1 N, in the shape of a residual."""

    def moved(self, state: State, step: Array) -> State:
        """Return the state after a step."""

    def deflection(self, state: State) -> float:
        """Return the displacement under the force, along it, m."""

    def deflection_of(self, step: Array) -> float:
        """Return what a step adds to it, m."""


@dataclass(frozen=True)
class Scales:
    """What counts as much as what: a deflection, m, and a force, N; and a residual that is none."""

    deflection: float
    force: float
    tolerance: float
    iterations: int = 8


@dataclass(frozen=True)
class PathPoint(Generic[State]):
    """An equilibrium: its state, force, N, and deflection, m."""

    state: State
    force: float
    deflection: float


def follow_arc(
    body: Loaded[State],
    start: State,
    scales: Scales,
    step: float,
    goes_on: Callable[[float, float], bool],
) -> Iterator[PathPoint[State]]:
    """Yield the equilibria from the one without force on, in steps along the curve.

    Parameters
    ----------
    body : Loaded
        What is loaded.
    start : state
        An equilibrium without force.
    scales : Scales
        Of the plane.
    step : float
        Length of a step in the plane of deflection and force over their scales.
    goes_on : callable
        Takes deflection and force of a point, says whether the path is to go on.
    """
    here = PathPoint(start, 0.0, body.deflection(start))
    direction = np.array([0.0, 1.0])  # the first step is one of the force
    length = step
    for _ in range(MOST_STEPS):
        if not goes_on(here.deflection, here.force):
            return
        there = _next_point(body, here, direction, length, scales)
        chord = direction if there is None else _in_plane(there, scales) - _in_plane(here, scales)
        if there is None or chord @ direction < SHARPEST_TURN * np.linalg.norm(chord):
            length /= 2
            if length < step * SHORTEST:
                raise _stuck(here)
            continue
        direction, here = chord / np.linalg.norm(chord), there
        length = min(1.5 * length, step)
        yield here
    raise _stuck(here)


def _stuck(here: PathPoint[State]) -> ComputationError:
    return ComputationError(f"no equilibrium beyond {here.deflection:.4g} m, {here.force:.4g} N")


def _in_plane(point: PathPoint[State], scales: Scales) -> Array:
    return np.array([point.deflection / scales.deflection, point.force / scales.force])


def _next_point(
    body: Loaded[State], here: PathPoint[State], direction: Array, step: float, scales: Scales
) -> PathPoint[State] | None:
    """Return the equilibrium on the line that lies a step ahead, across the direction."""
    goal = direction @ _in_plane(here, scales) + step
    state, force, unit = here.state, here.force, body.unit_force()
    across, along = direction / (scales.deflection, scales.force)
    for _ in range(scales.iterations):
        residual = body.residual(state, force)
        missing = goal - across * body.deflection(state) - along * force
        if np.linalg.norm(residual) <= scales.tolerance and abs(missing) <= 1e-9:
            return PathPoint(state, force, body.deflection(state))
        try:
            back, forth = body.solve(state, residual, unit)
        except ComputationError:  # an iterate far off has no tangent
            return None
        change = (missing + across * body.deflection_of(back)) / (
            across * body.deflection_of(forth) + along
        )
        state, force = body.moved(state, change * forth - back), force + change
    return None
