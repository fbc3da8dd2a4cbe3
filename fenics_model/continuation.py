"""The load path as a generator of equilibria: predict, solve, adapt the step."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from fenics_model.newton import Newton, NewtonOutcome
from fenics_model.step_control import StepControl


class PathError(ComputationError):
    """The load path cannot be followed further.

    Parameters
    ----------
    reason : str
        Why, in a few words.
    parameter : float
        Of the last equilibrium.
    iterations : int
        Spent on the failed attempts.
    """

    def __init__(self, reason: str, parameter: float, iterations: int) -> None:
        super().__init__(reason)
        self.parameter, self.iterations = parameter, iterations


@dataclass(frozen=True)
class Equilibrium:
    """A converged state on the path; the state itself is in the solver's function.

    Parameters
    ----------
    parameter : float
        Where on the path.
    milestone : int or None
        Which milestone this is, if it is one.
    iterations : int
        Newton iterations since the equilibrium before, failed attempts included.
    residual : float
        Relative to the reference.
    correction : float
        Norm of Newton's last correction, m.
    """

    parameter: float
    milestone: int | None
    iterations: int
    residual: float
    correction: float


class Predictor:
    """Extrapolates the last equilibria: the parabola through three, the secant through two."""

    def __init__(self, parameter: float, values: NDArray[np.float64]) -> None:
        self._known = [(parameter, values.copy())]

    def add(self, parameter: float, values: NDArray[np.float64]) -> None:
        """Learn an equilibrium."""
        self._known = [*self._known[-2:], (parameter, values.copy())]

    def at(self, parameter: float) -> NDArray[np.float64]:
        """Guess the state at a parameter (Lagrange's formula)."""
        guess = np.zeros_like(self.last)
        for t, values in self._known:
            others = [s for s, _ in self._known if s != t]
            guess += np.prod([(parameter - s) / (t - s) for s in others]) * values
        return guess

    @property
    def last(self) -> NDArray[np.float64]:
        """The last equilibrium."""
        return self._known[-1][1]


@dataclass(frozen=True)
class Tolerances:
    """Residuals relative to the reference: at milestones and on the way between them.

    The reference is at least `least_reference`, so that a state without prestretch and load, whose
    own is zero, has one.
    """

    milestone: float
    path: float
    least_reference: float


def follow(
    newton: Newton,
    load: Callable[[float], None],
    milestones: Sequence[float],
    control: StepControl,
    tolerances: Tolerances,
    start: float = 0.0,
) -> Iterator[Equilibrium]:
    """Follow the equilibria from the solver's present state through the milestones.

    Parameters
    ----------
    newton : Newton
        Its state is an equilibrium at `start`, and holds each equilibrium as it is yielded.
    load : callable
        Sets loads and natural states for a path parameter.
    milestones : sequence of float
        Parameters to hit exactly, ascending; those up to `start` count as reached.
    control : StepControl
        The first step and its limits.
    tolerances : Tolerances
        When a state counts as equilibrium.
    start : float
        Parameter of the present state.

    Raises
    ------
    PathError
        A step failed even at the smallest size; the state is the last equilibrium again.
    """
    values = newton.state.x.array
    predictor, here, spent = Predictor(start, values), start, 0
    index = sum(milestone <= start for milestone in milestones)
    while index < len(milestones):
        goal = milestones[index]
        step = control.step_toward(goal - here)
        there = goal if np.isclose(here + step, goal, rtol=0, atol=1e-12) else here + step
        load(there)
        tolerance = tolerances.milestone if there == goal else tolerances.path
        outcome, relative = equilibrate(
            newton, predictor.at(there), tolerance, tolerances.least_reference
        )
        spent += outcome.iterations
        if not outcome.converged:
            control = control.after_failure(step)
            if control.is_exhausted:
                values[:] = predictor.last
                load(here)
                reason = f"no convergence ({outcome.reason}) even with a load step of {step:.2g}"
                raise PathError(reason, here, spent)
            continue
        control = control.after_success(outcome.iterations)
        predictor.add(there, values)
        here = there
        reached = index if there == goal else None
        index += there == goal
        yield Equilibrium(there, reached, spent, relative, outcome.correction)
        spent = 0


def equilibrate(
    newton: Newton, guess: NDArray[np.float64], tolerance: float, least_reference: float
) -> tuple[NewtonOutcome, float]:
    """Solve from a guess; return the outcome and the residual relative to the reference."""
    reference = max(reference_residual(newton), least_reference)
    newton.state.x.array[:] = guess
    outcome = newton.solve(tolerance * reference)
    return outcome, outcome.residual / reference


def reference_residual(newton: Newton) -> float:
    """Residual of the undeformed mesh under the present natural states and loads; keeps the state.

    It measures what is to be balanced, so tolerances are relative to it.
    """
    values = newton.state.x.array
    kept = values.copy()
    values[:] = 0.0
    reference = newton.residual_norm()
    values[:] = kept
    return reference
