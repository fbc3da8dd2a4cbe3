"""The load path as a generator of equilibria: predict, solve, adapt the step.

Where no step leads on (a limit point, a sharp bifurcation) the load goes on and the body flows to
the next stable equilibrium; a milestone that turns out unstable is left for a stable branch.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.results.schema import UNKNOWN_STABILITY
from fenics_model.branches.branch_search import BranchSearch, Departure
from fenics_model.path.guide import Guide
from fenics_model.path.step_control import StepControl
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

FAILURES_BEFORE_FLOW = 3
"""Failed attempts at a load step after which the body flows instead (and after as many again)."""


class PathError(ComputationError):
    """The load path cannot be followed further.

    Parameters
    ----------
    reason : str
        Why, in a few words.
    parameter : float
        Of the last equilibrium.
    effort : Effort
        Spent on the failed attempts.
    """

    def __init__(self, reason: str, parameter: float, effort: Effort) -> None:
        super().__init__(reason)
        self.parameter, self.effort = parameter, effort


@dataclass(frozen=True)
class Equilibrium:
    """A converged state on the path; the state itself is in the solver's function.

    Parameters
    ----------
    parameter : float
        Where on the path.
    milestone : int or None
        Which milestone this is, if it is one.
    effort : Effort
        What it took since the equilibrium before, failed attempts included.
    residual : float
        Relative to the reference.
    unstable_modes : int
        Of a milestone; -1 where it is not known.
    departure : Departure or None
        Of a milestone where the path came to an unstable equilibrium: the search for others.
    """

    parameter: float
    milestone: int | None
    effort: Effort
    residual: float
    unstable_modes: int = UNKNOWN_STABILITY
    departure: Departure | None = None


class Predictor:
    """Extrapolates the last equilibria: the parabola through three, the secant through two."""

    def __init__(self, parameter: float, values: NDArray[np.float64]) -> None:
        self._known = [(parameter, values.copy())]

    def add(self, parameter: float, values: NDArray[np.float64]) -> None:
        """Learn an equilibrium; of two at one parameter, the second."""
        others = [(t, known) for t, known in self._known if t != parameter]
        self._known = [*others[-2:], (parameter, values.copy())]

    def at(self, parameter: float) -> NDArray[np.float64]:
        """Guess the state at a parameter (Lagrange's formula)."""
        guess = np.zeros_like(self.last)
        for t, values in self._known:
            others = [s for s, _ in self._known if s != t]
            guess += np.prod([(parameter - s) / (t - s) for s in others]) * values
        return guess

    @property
    def parameter(self) -> float:
        """Of the last equilibrium."""
        return self._known[-1][0]

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
    search: BranchSearch,
    load: Callable[[float], None],
    milestones: Sequence[float],
    control: StepControl,
    tolerances: Tolerances,
    guide: Guide,
) -> Iterator[Equilibrium]:
    """Follow the equilibria from the unloaded flat state through the milestones.

    Parameters
    ----------
    newton : Newton
        Its state is that at the parameter 0, and holds each equilibrium as it is yielded.
    search : BranchSearch
        Of the same solver; finds stable branches, and its flow a way where load steps fail.
    load : callable
        Sets loads and natural states for a path parameter.
    milestones : sequence of float
        Parameters to hit exactly, ascending.
    control : StepControl
        The first step and its limits.
    tolerances : Tolerances
        When a state counts as equilibrium.
    guide : Guide
        Leads straight to where it knows a shape.

    Raises
    ------
    PathError
        A step failed even at the smallest size; the state is the last equilibrium again.
    """
    tracker = _Tracker(newton, search, control, guide)
    here, index = 0.0, 0
    while index < len(milestones):
        goal = milestones[index]
        there = tracker.next_toward(goal, here)
        at_goal = there == goal
        load(there)
        reference = max(reference_residual(newton), tolerances.least_reference)
        accepted = reference * (tolerances.milestone if at_goal else tolerances.path)
        outcome = tracker.advance(there, accepted, reference)
        if not outcome.converged:
            if tracker.is_stuck:
                tracker.go_back()
                load(here)
                reason = f"no convergence ({outcome.reason}) even with a load step of "
                raise PathError(f"{reason}{there - here:.2g}", here, tracker.spent())
            continue
        modes = search.flow.unstable_modes() if at_goal else UNKNOWN_STABILITY
        departure = None
        if modes > 0:
            if tracker.gives_up_guide(there):
                continue
            departure = search.leave(modes, accepted, reference)
            modes = departure.unstable_modes
            outcome = tracker.departed(departure, there) or outcome
        tracker.learn(there)
        yield Equilibrium(
            there,
            index if at_goal else None,
            tracker.spent(),
            outcome.residual / reference,
            modes,
            departure,
        )
        here, index = there, index + at_goal


class _Tracker:
    """Keeps to a branch of equilibria, changes to another where it must, and counts the effort."""

    def __init__(
        self, newton: Newton, search: BranchSearch, control: StepControl, guide: Guide
    ) -> None:
        self._newton, self._search, self._guide = newton, search, guide
        self._first, self._control = control, control
        self._predictor = Predictor(0.0, newton.state.x.array)
        self._is_guided = False
        self._effort = Effort()

    @property
    def is_stuck(self) -> bool:
        """Whether the step was cut below the smallest one."""
        return self._control.is_exhausted

    def next_toward(self, goal: float, here: float) -> float:
        """Return the parameter of the next step: where the guide leads, or by the step control."""
        guided = self._guide.next_toward(goal, here)
        self._is_guided = guided is not None
        if guided is not None:
            return guided
        there = here + self._control.step_toward(goal - here)
        return goal if np.isclose(there, goal, rtol=0, atol=1e-12) else there

    def advance(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        """Solve from the predicted state; after some failures flow from the last equilibrium."""
        return (self._led if self._is_guided else self._stepped)(there, accepted, reference)

    def _led(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        """Go where the guide leads."""
        outcome, effort = self._guide.advance(there, accepted, reference)
        self._effort += effort
        return outcome

    def gives_up_guide(self, there: float) -> bool:
        """If the guide has led to the present, unstable state, go by load steps; say whether."""
        if not self._is_guided:
            return False
        self._guide.distrust(there, "unstable")
        self.go_back()
        return True

    def learn(self, there: float) -> None:
        """Take the present state for the equilibrium of a parameter."""
        self._predictor.add(there, self._newton.state.x.array)
        self._guide.learn(there)

    def _stepped(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        values, last = self._newton.state.x.array, self._predictor.parameter
        values[:] = self._predictor.at(there)
        outcome = self._newton.solve(accepted)
        self._effort += Effort(outcome.iterations)
        if outcome.converged:
            self._control = self._control.after_success(outcome.iterations)
            return outcome
        self._control = self._control.after_failure(there - last)
        if self._control.failures % FAILURES_BEFORE_FLOW and not self.is_stuck:
            return outcome
        self.go_back()
        flowed = self._search.flow.relax(accepted, reference)
        self._effort += flowed.effort
        return self._onto_another_branch(flowed.equilibrium, there) or outcome

    def departed(self, departure: Departure, there: float) -> NewtonOutcome | None:
        """Go on from the branch for which an unstable equilibrium was left, if it was."""
        self._effort += departure.effort
        return self._onto_another_branch(departure.equilibrium, there)

    def go_back(self) -> None:
        """Restore the last equilibrium."""
        self._newton.state.x.array[:] = self._predictor.last

    def spent(self) -> Effort:
        """Return the effort since the last call."""
        effort, self._effort = self._effort, Effort()
        return effort

    def _onto_another_branch(
        self, found: NewtonOutcome | None, there: float
    ) -> NewtonOutcome | None:
        """Begin anew where another branch was found, because the past predicts nothing."""
        if found is not None:
            self._control = self._first
            self._predictor = Predictor(there, self._newton.state.x.array)
        return found


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
