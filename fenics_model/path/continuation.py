"""The load path as a generator of equilibria: predict, solve, adapt the step.

If no step leads on (a limit point, a sharp bifurcation) the load goes on and the body flows to the
next stable equilibrium. A goal that turns out unstable is left for a stable branch.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.results.schema import UNKNOWN_STABILITY
from fenics_model.branches.branch_search import BranchSearch, BranchSearchOutcome
from fenics_model.branches.gradient_flow import FlowOutcome
from fenics_model.branches.stability import unstable_modes
from fenics_model.path.guide import Guide
from fenics_model.path.predictor import Predictor
from fenics_model.path.step_control import StepControl
from fenics_model.solid.state import State
from fenics_model.solve.effort import Effort
from fenics_model.solve.factors import Factors
from fenics_model.solve.newton import Newton, NewtonOutcome


@dataclass(frozen=True, eq=False)
class LoadPoint:
    """A state on the path, and how the path came to it.

    Parameters
    ----------
    parameter : float
        Where on the path.
    share : float
        Part of the way from the last goal to the next; 1 at the goal alone.
    state : State
        The state itself.
    effort : Effort
        The work since the equilibrium before, failed attempts included.
    residual : float
        Relative to the reference; NaN if the path stopped.
    unstable_modes : int
        Of a goal; -1 if it is not known.
    departure : BranchSearchOutcome or None
        Of a goal where the path came to an unstable equilibrium: the search for others.
    """

    parameter: float
    share: float
    state: State
    effort: Effort
    residual: float
    unstable_modes: int = UNKNOWN_STABILITY
    departure: BranchSearchOutcome | None = None


@dataclass(frozen=True)
class Tolerances:
    """Residuals relative to the reference: at goals and on the way between them.

    The reference is at least `least_reference`, so that a state without prestretch and load, whose
    own is zero, has one. `round_off` is the residual, N, below which no state can be asked to go.
    """

    goal: float
    path: float
    least_reference: float
    round_off: float = 0.0


class Continuation:
    """Follows a branch of equilibria of a body along a load parameter, from goal to goal.

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
    failures_before_flow : int
        Failed attempts at a load step after which the body flows instead (and after as many again).

    Attributes
    ----------
    predictor : Predictor
        Knows the last equilibria; at first the undeformed state at the parameter 0.
    control : StepControl
        The next step.
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
        failures_before_flow: int = 3,
    ) -> None:
        self._newton, self._search, self._load = newton, search, load
        self._first, self.control = control, control
        self._tolerances, self._guide = tolerances, guide
        self._failures_before_flow = failures_before_flow
        self.predictor = Predictor([(0.0, newton.solid.undeformed)])
        self._begin, self._goal = 0.0, 0.0
        self._effort = Effort()

    @property
    def parameter(self) -> float:
        """Of the last equilibrium."""
        return self.predictor.parameter

    def begin_at(self, parameter: float, state: State) -> None:
        """Begin anew near a state at a parameter, which predicts nothing."""
        self._change_branch(parameter, state)

    def approach(self, goal: float) -> Iterator[LoadPoint]:
        """Follow the equilibria from the last one to a parameter.

        Yields
        ------
        LoadPoint
            Each one on the way; the last is at the goal.

        Raises
        ------
        ComputationError
            A step failed even at the smallest size.
        """
        self._begin, self._goal = self.parameter, goal
        if self.control.is_exhausted:  # on the way to another goal
            self.control = self._first
        self._newton.stopwatch.restart()
        point = None
        while point is None or point.share < 1:
            point = self._advance(goal)
            if point is not None:
                yield replace(point, effort=self._take_effort(load_steps=1))
                self._newton.stopwatch.restart()

    def begin_anew(self, slope: NDArray[np.float64] | None) -> None:
        """Expect nothing of the equilibria before the last one: another kind of load follows.

        Parameters
        ----------
        slope : array of float or None
            Expected change of the state over that of the parameter.
        """
        self._change_branch(self.parameter, self.predictor.last)
        self.predictor = Predictor(self.predictor.known, slope)

    def stopped(self) -> LoadPoint:
        """Return the last equilibrium, with the work done in vain since then."""
        self._load(self.parameter)
        share = self._share(self.parameter)
        effort = self._take_effort(load_steps=0)
        return LoadPoint(self.parameter, share, self.predictor.last, effort, math.nan)

    def _share(self, parameter: float) -> float:
        return (parameter - self._begin) / (self._goal - self._begin or 1.0)

    def _advance(self, goal: float) -> LoadPoint | None:
        """Attempt one step; None if it failed and a smaller one is due."""
        self._newton.set_out_from(self.predictor.last)
        guided = None if self._guide is None else self._guide.propose_step(self.parameter, goal)
        there = self._next_step(goal) if guided is None else guided
        self._load(there)
        undeformed = self._newton.residual_norm(self._newton.solid.undeformed)
        reference = max(undeformed, self._tolerances.least_reference)
        at_goal = there == goal
        tolerance = self._tolerances.goal if at_goal else self._tolerances.path
        accepted = max(reference * tolerance, self._tolerances.round_off)
        take_step = self._take_load_step if guided is None else self._follow_guide
        outcome = take_step(there, accepted, reference)
        if not outcome.converged:
            resort = self._flow_on(goal) if self.control.is_exhausted else None
            if resort is None:
                self._stop_if_stuck(there, outcome)
            return resort
        share = 1.0 if at_goal else self._share(there)
        found = LoadPoint(there, share, outcome.state, Effort(), outcome.residual / reference)
        if at_goal:
            stable = self._make_stable(found, accepted, reference, guided is not None)
            if stable is None:
                return None
            found = stable
        self._record_equilibrium(found)
        return found

    def _next_step(self, goal: float) -> float:
        """Return the parameter of the next load step, by the step control."""
        way = goal - self.parameter
        there = self.parameter + math.copysign(self.control.step_toward(abs(way)), way)
        return goal if np.isclose(there, goal, rtol=0, atol=1e-12) else there

    def _stop_if_stuck(self, there: float, outcome: NewtonOutcome) -> None:
        """Raise an error if the step was cut below the smallest one."""
        if self.control.is_exhausted:
            step = there - self.parameter
            raise ComputationError(
                f"no convergence ({outcome.reason}) even with a load step of {step:.2g}"
            )

    def _follow_guide(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        assert self._guide is not None
        outcome, effort = self._guide.take_step(there, self.predictor.last, accepted, reference)
        self._effort += effort
        return outcome

    def _take_load_step(self, there: float, accepted: float, reference: float) -> NewtonOutcome:
        """Solve from the predicted state; after some failures flow from the last equilibrium."""
        predicted = self.predictor.guess(there)
        outcome = self._newton.solve(predicted, accepted)
        self._effort += Effort(outcome.iterations)
        if outcome.converged and self._is_far(predicted, outcome.state):
            outcome = replace(outcome, converged=False, reason="another branch")
        if outcome.converged:
            self.control = self.control.after_success(outcome.corrections)
            return outcome
        self.control = self.control.after_failure(abs(there - self.parameter))
        if self.control.failures % self._failures_before_flow and not self.control.is_exhausted:
            return outcome
        flowed = self._search.flow.flow_to_equilibrium(self.predictor.last, accepted, reference)
        self._effort += flowed.effort
        if flowed.equilibrium is None:
            return outcome
        self._change_branch(there, flowed.equilibrium.state)
        return flowed.equilibrium

    def _is_far(self, predicted: State, found: State) -> bool:
        """Whether a solution is farther from its prediction than that is from where it was made.

        Then it is on another branch: accelerated corrections may come to one beyond a limit point.
        Without a past there is no prediction.
        """
        norm, here = self._newton.solid.displacement_norm, self.predictor.last
        has_past = len(self.predictor.known) > 1
        return has_past and norm(found - predicted) > norm(predicted - here)

    def _make_stable(
        self, found: LoadPoint, accepted: float, reference: float, is_guided: bool
    ) -> LoadPoint | None:
        """Count the unstable modes of a goal, and leave it if there are any.

        If the guide has led to an unstable state, the body flows from the guide's shape. If that
        leads nowhere, the state is left as any other; if that, too, ends at an unstable one, load
        steps are to be taken instead: None.
        """
        with self._newton.factorise(found.state) as factors:
            modes = self._count_modes(factors)
            if modes <= 0:
                return replace(found, unstable_modes=modes)
            if not is_guided or self._search.stays:
                return self._leave_unstable(found, factors, accepted, reference)
        stable = self._flow_from_shape(found, accepted, reference)
        if stable is None:
            with self._newton.factorise(found.state) as factors:
                stable = self._leave_unstable(found, factors, accepted, reference)
        return stable if stable.unstable_modes <= 0 else None

    def _leave_unstable(
        self, found: LoadPoint, factors: Factors, accepted: float, reference: float
    ) -> LoadPoint:
        """Return the goal after a search for stable branches; as it was if none is to be taken."""
        departure = self._search.leave_unstable(found.state, factors, accepted, reference)
        self._effort += departure.effort
        left = replace(found, unstable_modes=departure.unstable_modes, departure=departure)
        taken = departure.equilibrium
        if taken is None:
            return left
        self._change_branch(found.parameter, taken.state)
        return replace(left, state=taken.state, residual=taken.residual / reference)

    def _flow_from_shape(
        self, found: LoadPoint, accepted: float, reference: float
    ) -> LoadPoint | None:
        """Return the stable equilibrium that the body flows to from the guide's shape."""
        assert self._guide is not None
        flowed = self._guide.flow_from_shape(found.parameter, accepted, reference, "unstable")
        return self._rest_of(flowed, found, reference)

    def _rest_of(self, flowed: FlowOutcome, found: LoadPoint, reference: float) -> LoadPoint | None:
        """Return a goal at the end of a flow; None if it has found no stable equilibrium."""
        self._effort += flowed.effort
        rest = flowed.equilibrium
        if rest is None:
            return None
        with self._newton.factorise(rest.state) as factors:
            modes = self._count_modes(factors)
        return replace(
            found, state=rest.state, residual=rest.residual / reference, unstable_modes=modes
        )

    def _flow_on(self, goal: float) -> LoadPoint | None:
        """Return the goal if a flow from the guide's shape, begun before, leads there after all."""
        if self._guide is None:
            return None
        self._load(goal)
        undeformed = self._newton.residual_norm(self._newton.solid.undeformed)
        reference = max(undeformed, self._tolerances.least_reference)
        flowed = self._guide.flow_on(goal, self._tolerances.goal * reference, reference)
        if flowed is None:
            return None
        here = LoadPoint(goal, 1.0, flowed.state, Effort(), math.nan)
        found = self._rest_of(flowed, here, reference)
        if found is not None:
            self._change_branch(goal, found.state)
            self._record_equilibrium(found)
        return found

    def _count_modes(self, factors: Factors) -> int:
        return unstable_modes(factors, self._newton.solid.number_of_pressures)

    def _change_branch(self, parameter: float, state: State) -> None:
        """Begin anew on another branch, because the past predicts nothing."""
        self.control = self._first
        self.predictor = Predictor([(parameter, state)])

    def _record_equilibrium(self, found: LoadPoint) -> None:
        self.predictor.record_equilibrium(found.parameter, found.state)
        if self._guide is not None:
            self._guide.record_defect(found.parameter, found.state)

    def _take_effort(self, load_steps: int) -> Effort:
        """Return the work since the last call."""
        effort = self._effort + Effort(load_steps=load_steps, work=self._newton.stopwatch.take())
        self._effort = Effort()
        return effort
