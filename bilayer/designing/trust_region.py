"""A minimiser within a trust region, for functions that cost much and may fail.

Each step minimises a quadratic model within a box around the best point so far, under bounds and
constraints that cost nothing (SciPy's SLSQP). The model's curvature is the function's own, such as
that of Gauss and Newton, or else a damped BFGS update (Powell 1978; Nocedal and Wright, Numerical
Optimization, procedure 18.2). The box shrinks if the function
cannot be computed or has not fallen, and grows if the model was right.

The way depends on nothing but the values: with the same values it is the same.
"""

import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.errors import ComputationError

Array = NDArray[np.float64]

GOOD, ENOUGH = 0.7, 0.05
"""Fall of the function over that of the model: the box grows above, the step counts above."""
SHRINK, FAIL, GROW = 0.5, 0.3, 2.0
DAMPING = 0.2
LARGEST_RADIUS = 0.5
BELOW, ABOVE = 0.7, 1.2
"""The box grows to so much of a step that was in vain, and to so much more after each good one."""
DIFFERENCE = 1e-5
"""Of a variable, for the slopes of the constraints."""


class NoValueError(ComputationError):
    """A function has no value at a point; it may have one nearer to the best one."""


class Evaluated(Protocol):
    """A function's value at a point."""

    @property
    def value(self) -> float:
        """The value."""

    @property
    def gradient(self) -> Array:
        """Its derivatives, (n,)."""

    @property
    def curvature(self) -> Array | None:
        """An approximation of its second derivatives, (n, n), positive semidefinite; or None."""

    @property
    def is_admissible(self) -> bool:
        """Whether the minimiser may stay here."""

    @property
    def margins(self) -> Array:
        """What shall not be negative, as dear as the value, (m,).

        Its slopes are learnt from one evaluation to the next.
        """


E = TypeVar("E", bound=Evaluated)


@dataclass(frozen=True)
class Limits:
    """When the search ends.

    Parameters
    ----------
    evaluations : int
        Most of them, failed ones included.
    radius : float
        Half the first box's width, each variable going from 0 to 1.
    least_radius : float
        The search ends below.
    """

    evaluations: int
    radius: float = 0.1
    least_radius: float = 1e-3


@dataclass(frozen=True, eq=False)
class Iterate(Generic[E]):
    """A step of the search.

    Parameters
    ----------
    evaluations : int
        So many were done, this one included.
    point : (n,) array of float
        The best point so far.
    best : Evaluated
        What is there.
    tried : Evaluated or None
        What was computed last; None if that failed.
    radius : float
        Half the width of the next box.
    curvature : (n, n) array of float
        Of the model.
    failure : str
        Why the last evaluation failed; empty if it did not.
    ceiling : float
        To which the radius may grow: less than of steps that were in vain.
    slopes : (m, n) array of float
        Of the margins, as far as they are learnt; 0 along ways that were not gone.
    """

    evaluations: int
    point: Array
    best: E
    tried: E | None
    radius: float
    curvature: Array
    failure: str
    ceiling: float
    slopes: Array


def search(
    evaluate: Callable[[Array, E | None], E],
    start: Array,
    limits: Limits,
    constraints: Callable[[Array], Array] | None = None,
) -> Iterator[Iterate[E]]:
    """Yield the steps of the search for a minimum, each variable between 0 and 1.

    Parameters
    ----------
    evaluate : callable
        Takes a point and what was found at the best point so far, None at first. Raises
        NoValueError if there is no value.
    start : (n,) array of float
        Where the search begins.
    limits : Limits
        Where it ends.
    constraints : callable, optional
        Returns numbers that shall not be negative.

    Raises
    ------
    NoValueError
        The first evaluation fails.
    """
    best = evaluate(start, None)
    steepest = float(np.abs(best.gradient).max()) or 1.0
    first: Array = np.asarray(np.eye(len(start)) * steepest / limits.radius)
    curvature = first if best.curvature is None else best.curvature
    slopes = np.zeros((len(best.margins), len(start)))
    here = Iterate(1, start, best, best, limits.radius, curvature, "", LARGEST_RADIUS, slopes)
    yield here
    while here.evaluations < limits.evaluations and here.radius >= limits.least_radius:
        step = model_step(here, constraints)
        if np.abs(step).max() < 1e-9:
            return
        here = _after(here, step, evaluate)
        yield here


def model_step(here: Iterate[Any], constraints: Callable[[Array], Array] | None) -> Array:
    """Return the step to the model's minimum within the box, (n,)."""
    gradient, curvature = here.best.gradient, here.curvature
    scale = float(np.abs(gradient).max()) * here.radius or 1.0
    low = np.maximum(-here.radius, -here.point)
    high = np.minimum(here.radius, 1 - here.point)
    low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    shall = [] if constraints is None else [_linear(constraints, here.point, low, high)]
    if len(here.slopes):
        shall.append(_at_least(here.best.margins, here.slopes))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of steps beyond a bound by round-off
        found = scipy.optimize.minimize(
            lambda step: (gradient @ step + step @ curvature @ step / 2) / scale,
            np.zeros_like(gradient),
            jac=lambda step: (gradient + curvature @ step) / scale,
            bounds=list(zip(low, high, strict=True)),
            constraints=shall,
            method="SLSQP",
            options={"ftol": 1e-10, "maxiter": 200},
        )
    return np.asarray(np.clip(found.x, low, high))


def _linear(
    constraints: Callable[[Array], Array], point: Array, low: Array, high: Array
) -> dict[str, Any]:
    """Return constraints, linear about a point, as SLSQP takes them."""
    at = constraints(point)
    steps = np.where(high > -low, DIFFERENCE, -DIFFERENCE)
    slopes = np.column_stack(
        [
            (constraints(point + step * axis) - at) / step
            for step, axis in zip(steps, np.eye(len(point)), strict=True)
        ]
    )
    return _at_least(at, slopes)


def _at_least(at: Array, slopes: Array) -> dict[str, Any]:
    """Return linear margins that shall not be negative; one that is shall not become worse."""
    at = np.maximum(at, 0.0)
    return {"type": "ineq", "fun": lambda step: at + slopes @ step, "jac": lambda step: slopes}


def _after(here: Iterate[E], step: Array, evaluate: Callable[[Array, E | None], E]) -> Iterate[E]:
    """Return the search after a step was tried."""
    count = here.evaluations + 1
    try:
        there = evaluate(here.point + step, here.best)
    except NoValueError as error:
        length = min(here.radius, float(np.abs(step).max()))
        return replace(
            here, evaluations=count, tried=None, radius=FAIL * length, failure=str(error),
            ceiling=BELOW * length,
        )  # fmt: skip
    expected = -float(here.best.gradient @ step + step @ here.curvature @ step / 2)
    fall = here.best.value - there.value
    curvature = there.curvature
    if curvature is None:
        curvature = updated(here.curvature, step, there.gradient - here.best.gradient)
    ratio = fall / expected if expected > 0 else -1.0
    slopes = _learnt(here.slopes, step, there.margins - here.best.margins)
    holds = bool((there.margins >= np.minimum(here.best.margins, 0.0)).all())
    taken = ratio > ENOUGH and there.is_admissible and holds
    length = float(np.abs(step).max())
    radius, ceiling = here.radius, here.ceiling
    if not taken or ratio < ENOUGH:
        radius = SHRINK * min(radius, length)
        ceiling = BELOW * min(here.radius, length)
    elif ratio > GOOD and length > 0.8 * radius:
        ceiling = min(ABOVE * ceiling, LARGEST_RADIUS)
        radius = max(radius, min(GROW * radius, ceiling))
    if taken:
        point = here.point + step
        return Iterate(count, point, there, there, radius, curvature, "", ceiling, slopes)
    if there.curvature is not None:
        curvature = here.curvature
    return replace(
        here, evaluations=count, tried=there, radius=radius, curvature=curvature, failure="",
        ceiling=ceiling, slopes=slopes,
    )  # fmt: skip


def _learnt(slopes: Array, step: Array, change: Array) -> Array:
    """Return slopes that give the change along the last step, and else are as before.

    Broyden, Mathematics of Computation 19, 577 (1965).
    """
    return np.asarray(slopes + np.outer(change - slopes @ step, step) / (step @ step))


def updated(curvature: Array, step: Array, change: Array) -> Array:
    """Return a curvature after the damped BFGS update, positive definite as before.

    Parameters
    ----------
    curvature : (n, n) array of float
        Before.
    step, change : (n,) array of float
        Of the point, of the gradient.
    """
    pushed = curvature @ step
    along = float(step @ pushed)
    if along <= 0:
        return curvature
    product = float(step @ change)
    share = 1.0 if product >= DAMPING * along else (1 - DAMPING) * along / (along - product)
    mixed = share * change + (1 - share) * pushed
    return np.asarray(
        curvature - np.outer(pushed, pushed) / along + np.outer(mixed, mixed) / float(step @ mixed)
    )
