"""The load path as a generator of equilibria: predict, solve, adapt the step.

If no step leads on (a limit point, a sharp bifurcation) the load goes on and the body flows to the
next stable equilibrium. A goal that turns out unstable is left for a stable branch.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from bilayer.errors import ComputationError
from bilayer.results.result import UNKNOWN_STABILITY
from fenics_model.branches.branch_search import BranchSearch, Departure
from fenics_model.branches.stability import unstable_modes
from fenics_model.path.guide import Guide
from fenics_model.path.predictor import Predictor
from fenics_model.path.step_control import StepControl
from fenics_model.solid.state import State
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome


class PathError(ComputationError):
    """The load path cannot be followed further.

    Parameters
    ----------
    reason : str
        Why, in a few words.
    parameter : float
        Of the last equilibrium.
    effort : Effort
        Of the failed attempts.
    """

    def __init__(self, reason: str, parameter: float, effort: Effort) -> None:
        super().__init__(reason)
        self.parameter, self.effort = parameter, effort


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A converged state on the path.

    Parameters
    ----------
    parameter : float
        Where on the path.
    state : State
        The state itself.
    is_goal : bool
        Whether it was asked for, or lies on the way.
    effort : Effort
        What it took since the equilibrium before, failed attempts included.
    residual : float
        Relative to the reference.
    unstable_modes : int
        Of a goal; -1 if it is not known.
    departure : Departure or None
        Of a goal where the path came to an unstable equilibrium: the search for others.
    """

    parameter: float
    state: State
    is_goal: bool
    effort: Effort
    residual: float
    unstable_modes: int = UNKNOWN_STABILITY
    departure: Departure | None = None


@dataclass(frozen=True)
class Tolerances:
    """Residuals relative to the reference: at goals and on the way between them.

    The reference is at least `least_reference`, so that a state without prestretch and load, whose
    own is zero, has one.
    """

    milestone: float
    path: float
    least_reference: float


class Continuation:
    """Follows a branch of equilibria of a body along a load parameter that grows.

    Parameters
    ----------
    newton : Newton
        Solves.
    search : BranchSearch
        Of the same solver; finds stable branches, and its flow a way if load steps fail.
    load : callable
        Sets loads and natural states for a parameter.
    control : StepControl
        The first step and its limits.
    tolerances : Tolerances
        When a state counts as equilibrium.
    guide : Guide, optional
        Leads straight to where it knows a shape.
    start : State, optional
        The equilibrium at the parameter 0; undeformed if left out.
    failures_before_flow : int
        Failed attempts at a load step after which the body flows instead (and after as many again).
    """

    def __init__(
        self,
        newton: Newton,
        search: BranchSearch,
        load: Callable[[float], None],
        control: StepControl,
        tolerances: Tolerances,
        *,
        guide: Guide | None = None,
        start: State | None = None,
        failures_before_flow: int = 3,
    ) -> None:
        self._newton, self._search, self._load = newton, search, load
        self._first, self._control = control, control
        self._tolerances, self._guide = tolerances, guide
        self._failures_before_flow = failures_before_flow
        begin = newton.solid.undeformed if start is None else start
        self._predictor = Predictor([(0.0, begin)])
        self._effort = Effort()

    @property
    def parameter(self) -> float:
        """Of the last equilibrium."""
        return self._predictor.parameter

    @property
    def state(self) -> State:
        """The last equilibrium."""
        return self._predictor.last

    def approach(self, goal: float) -> Iterator[Equilibrium]:
        """Follow the equilibria from the last one to a parameter; the last one is the goal.

        Raises
        ------
        PathError
            A step failed even at the smallest size.
        """
        while True:
            equilibrium = self._advance(goal)
            if equilibrium is None:
                continue
            yield equilibrium
            if equilibrium.is_goal:
                return

    def _advance(self, goal: float) -> Equilibrium | None:
        """Attempt one step; None if it failed and a smaller one is due."""
        guided = None if self._guide is None else self._guide.propose_step(self.parameter, goal)
        there = self._next_step(goal) if guided is None else guided
        self._load(there)
        undeformed = self._newton.residual_norm(self._newton.solid.undeformed)
        reference = max(undeformed, self._tolerances.least_reference)
        at_goal = there == goal
        share = self._tolerances.milestone if at_goal else self._tolerances.path
        take_step = self._take_load_step if guided is None else self._follow_guide
        outcome = take_step(there, share * reference, reference)
        if not outcome.converged:
            self._stop_if_stuck(there, outcome)
            return None
        found = Equilibrium(there, outcome.state, at_goal, Effort(), outcome.residual / reference)
        if at_goal:
            stable = self._make_stable(found, share * reference, reference, guided is not None)
            if stable is None:
                return None
            found = stable
        self._learn(found)
        return replace(found, effort=self._take_effort())

    def _next_step(self, goal: float) -> float:
        """Return the parameter of the next load step, by the step control."""
        there = self.parameter + self._control.step_toward(goal - self.parameter)
        return goal if np.isclose(there, goal, rtol=0, atol=1e-12) else there

    def _stop_if_stuck(self, there: float, outcome: NewtonOutcome) -> None:
        """Raise an error if the step was cut below the smallest one."""
        if not self._control.is_exhausted:
            return
        step = there - self.parameter
        self._load(self.parameter)
        reason = f"no convergence ({outcome.reason}) even with a load step of {step:.2g}"
        raise PathError(reason, self.parameter, self._take_effort())

    def _follow_guide(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        assert self._guide is not None
        outcome, effort = self._guide.take_step(there, self.state, accepted, reference)
        self._effort += effort
        return outcome

    def _take_load_step(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        """Solve from the predicted state; after some failures flow from the last equilibrium."""
        outcome = self._newton.solve(self._predictor.guess(there), accepted)
        self._effort += Effort(outcome.iterations)
        if outcome.converged:
            self._control = self._control.after_success(outcome.iterations)
            return outcome
        self._control = self._control.after_failure(there - self.parameter)
        if self._control.failures % self._failures_before_flow and not self._control.is_exhausted:
            return outcome
        flowed = self._search.flow.relax(self.state, accepted, reference)
        self._effort += flowed.effort
        if flowed.equilibrium is None:
            return outcome
        self._change_branch(there, flowed.equilibrium.state)
        return flowed.equilibrium

    def _make_stable(
        self, found: Equilibrium, accepted: float, reference: float, is_guided: bool
    ) -> Equilibrium | None:
        """Count the unstable modes of a goal, and leave it if there are any.

        If the guide has led to an unstable state, load steps are to be taken instead: None.
        """
        with self._newton.factorise(found.state) as factors:
            modes = unstable_modes(factors, self._newton.solid.number_of_pressures)
            if modes <= 0:
                return replace(found, unstable_modes=modes)
            if is_guided and self._guide is not None:
                self._guide.distrust(found.parameter, "unstable")
                return None
            departure = self._search.leave_unstable(found.state, factors, accepted, reference)
        self._effort += departure.effort
        left = replace(found, unstable_modes=departure.unstable_modes, departure=departure)
        taken = departure.equilibrium
        if taken is None:
            return left
        self._change_branch(found.parameter, taken.state)
        return replace(left, state=taken.state, residual=taken.residual / reference)

    def _change_branch(self, parameter: float, state: State) -> None:
        """Begin anew on another branch, because the past predicts nothing."""
        self._control = self._first
        self._predictor = Predictor([(parameter, state)])

    def _learn(self, found: Equilibrium) -> None:
        self._predictor.learn(found.parameter, found.state)
        if self._guide is not None:
            self._guide.learn(found.parameter, found.state)

    def _take_effort(self) -> Effort:
        """Return the effort since the last call."""
        effort, self._effort = self._effort, Effort()
        return effort
