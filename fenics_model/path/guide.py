"""Load steps that another result's shapes predict, straight from one shape to the next.

A shape of the guide, made a state of the solid, differs from the solid's equilibrium by a defect.
The defect at the next parameter is extrapolated from the last three and added to the guide's state.
This is the initial guess of Newton's method. If the solution is far from the guess, it is on
another branch and does not count. If there is no other, the shape alone is the next guess: where
one of the two bodies has changed its branch, the defects before say nothing. If that fails, too,
the body flows to a stable equilibrium from the guess of least energy, or from the last equilibrium
at the loads of the next if that is lower. If it finds none, the step is rejected.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.results.starting import LONGEST_WAY
from fenics_model.branches.gradient_flow import FlowOutcome, GradientFlow
from fenics_model.path.predictor import MEMORY, extrapolation_weights
from fenics_model.solid.state import State
from fenics_model.solve.corrections import CorrectionRule
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GuideRule:
    """Limits within which the shapes of a guide are used.

    Parameters
    ----------
    far_from_balance : float
        Residual of a guess, over the reference, above which it is relaxed with its surface held. A
        nearer one is relaxed, too, if Newton's method fails from it.
    relaxed_residual : float
        Residual, over the reference, down to which it is relaxed.
    far_from_guess : float
        Largest distance of a solution from its prediction, over the length of the predicted step.
    far_in_contact : float
        The same if the body presses on itself: there a small difference between the two bodies
        decides where, and what was extrapolated bends off.
    longest_way : float
        Change of the prestretch up to which a shape is in reach.
    iteration_limit : int
        New tangents after which a solution has failed. Load steps instead would take more.
    corrections : CorrectionRule
        Of a solution.
    flow_steps : int
        Time steps of a flow from a shape.
    further_flows : int
        Flows that go on from its end where no load step leads on.
    """

    far_from_balance: float = 0.5
    relaxed_residual: float = 0.1
    far_from_guess: float = 0.5
    far_in_contact: float = 1.5
    longest_way: float = LONGEST_WAY
    iteration_limit: int = 5
    corrections: CorrectionRule = field(default_factory=lambda: CorrectionRule(fruitless=1.0))
    flow_steps: int = 100
    further_flows: int = 3


STAYING = GuideRule(iteration_limit=20, corrections=CorrectionRule(), flow_steps=0)
"""Of a path that leaves no unstable equilibrium: more tangents, because a flow would leave it."""


class Guide:
    """Another result's shapes as states of the solid, and how far they are from its equilibria.

    Parameters
    ----------
    newton : Newton
        Solves for the equilibria.
    extrude : callable
        Makes a state of a shape of the reference surface, with the natural states of the moment.
    relax_guess : callable
        Relaxes a state to a norm of the residual, that surface held; returns the outcome.
    flow : GradientFlow
        Of the same solver; goes from a shape to a stable equilibrium if Newton's method does not.
    rule : GuideRule, optional
        Limits within which it is used.

    Attributes
    ----------
    rejected : list of (float, str)
        Path parameters of the shapes that were rejected, each with the reason.
    """

    def __init__(
        self,
        newton: Newton,
        extrude: Callable[[Array], State],
        relax_guess: Callable[[State, float], NewtonOutcome],
        flow: GradientFlow,
        rule: GuideRule | None = None,
    ) -> None:
        self._newton, self._extrude, self._relax_guess = newton, extrude, relax_guess
        self._flow, self._guess = flow, newton.solid.undeformed
        self._rule = GuideRule() if rule is None else rule
        self._shapes: dict[float, Array] = {}
        self._states: dict[float, State] = {}
        self._unfinished: tuple[float, State] | None = None
        self.defects: list[tuple[float, Array]] = []
        self._is_as_predicted = False
        self.is_trusted = True
        self.rejected: list[tuple[float, str]] = []

    def use_shapes(self, shapes: Mapping[float, Array]) -> None:
        """Use these shapes from now on, and forget those before.

        Parameters
        ----------
        shapes : mapping of float to (n, 3) array of float
            The reference surface by path parameter, m, where the solid is held.
        """
        self._shapes, self._states, self._unfinished = dict(shapes), {}, None

    def restore(
        self,
        defects: Sequence[tuple[float, Array]],
        is_trusted: bool,
        rejected: Sequence[tuple[float, str]],
    ) -> None:
        """Restore the defects and rejections of another time."""
        self.defects, self.is_trusted, self.rejected = list(defects), is_trusted, list(rejected)

    def propose_step(self, here: float, goal: float) -> float | None:
        """Return the parameter of the farthest shape in reach; None if no shape is to be used."""
        ahead = sorted(there for there in self._shapes if here < there <= goal)
        if not ahead or not self.is_trusted:
            return None
        farthest = here + self._rule.longest_way * (1 + 1e-9)
        in_reach = [there for there in ahead if there <= farthest]
        return in_reach[-1] if in_reach else ahead[0]

    def take_step(
        self, there: float, before: State, accepted: float, reference: float
    ) -> tuple[NewtonOutcome, Effort]:
        """Step from an equilibrium to a shape, whose loads already act.

        If the step is rejected, no further one is proposed until `record_defect`.

        Parameters
        ----------
        there : float
            The path parameter.
        before : State
            The equilibrium.
        accepted : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        """
        guesses, effort = self._guesses(there), Effort(guided_steps=1)
        starts = []
        for guess in guesses:
            outcome, start, iterations = self._solve_from(guess, accepted, reference)
            effort += Effort(iterations)
            if outcome.converged and self._is_far_from_guess(before, guess, outcome.state):
                outcome = replace(outcome, converged=False, reason="another branch")
            starts.append(start)
            if outcome.converged:
                self._guess, self._is_as_predicted = start, guess is guesses[0]
                return outcome, effort
        clear = [start for start in starts if not self._newton.passes_through(start)]
        self._guess = self._flow.lowest([*(clear or starts), before])
        flowed = self.flow_from_shape(there, accepted, reference, outcome.reason)
        effort += flowed.effort
        return (outcome if flowed.equilibrium is None else flowed.equilibrium), effort

    def _guesses(self, there: float) -> list[State]:
        """Return the shape with the defect that is expected of it, and the shape alone."""
        shape = self._state_at(there)
        return [shape + self._defect_at(there), shape] if self.defects else [shape]

    def _solve_from(
        self, guess: State, accepted: float, reference: float
    ) -> tuple[NewtonOutcome, State, int]:
        """Solve from a guess, relaxed if need be with its surface held.

        Returns
        -------
        outcome : NewtonOutcome
            Of the solution.
        start : State
            Where it began: the guess, relaxed if that went well.
        iterations : int
            What all of it took.
        """
        iterations = 0
        if self._newton.residual_norm(guess) < self._rule.far_from_balance * reference:
            outcome = self._solve(guess, accepted)
            iterations += outcome.iterations
            if outcome.converged:
                return outcome, guess, iterations
        relaxed = self._relax_guess(guess, self._rule.relaxed_residual * reference)
        iterations += relaxed.iterations
        if not relaxed.converged:
            return relaxed, guess, iterations
        outcome = self._solve(relaxed.state, accepted)
        return outcome, relaxed.state, iterations + outcome.iterations

    def _solve(self, guess: State, accepted: float) -> NewtonOutcome:
        rule = self._rule
        return self._newton.solve(
            guess, accepted, iteration_limit=rule.iteration_limit, rule=rule.corrections
        )

    def flow_from_shape(
        self, there: float, accepted: float, reference: float, reason: str
    ) -> FlowOutcome:
        """Flow to a stable equilibrium from the guess of the last step, which did not lead to one.

        The shape is rejected if that fails, too, for the reason why the step did.
        """
        self._is_as_predicted = False
        if self._newton.passes_through(self._guess):  # a flow from there would stay so
            self.reject_shape(there, reason)
            return FlowOutcome(self._guess, None, Effort())
        flowed = self._flow.flow_to_equilibrium(
            self._guess, accepted, reference, step_limit=self._rule.flow_steps
        )
        if flowed.equilibrium is None:
            self.reject_shape(there, reason)
            self._unfinished = there, flowed.state
        return flowed

    def flow_on(self, there: float, accepted: float, reference: float) -> FlowOutcome | None:
        """Continue a flow from a shape that has not come to an end; None if there is none."""
        if self._unfinished is None or self._unfinished[0] != there:
            return None
        flowed, effort = FlowOutcome(self._unfinished[1], None, Effort()), Effort()
        for _ in range(self._rule.further_flows):
            flowed = self._flow.flow_to_equilibrium(flowed.state, accepted, reference)
            effort += flowed.effort
            if flowed.equilibrium is not None or flowed.unstable is not None:
                break
        self._unfinished = None
        return replace(flowed, effort=effort)

    def _is_far_from_guess(self, before: State, predicted: State, found: State) -> bool:
        """Whether a solution is so far from its prediction that it is on another branch."""
        norm, rule = self._newton.solid.displacement_norm, self._rule
        far = rule.far_in_contact if self._newton.touches(found) else rule.far_from_guess
        return norm(found - predicted) > far * norm(before - predicted)

    def reject_shape(self, there: float, reason: str) -> None:
        """Propose no step until the equilibrium at one of the shapes is known; note the reason."""
        self.is_trusted = False
        self.rejected.append((there, reason))

    def record_defect(self, parameter: float, state: State) -> None:
        """Record the defect of the shape at a parameter, if there is one.

        If it is not what those before led to expect, the next one is not expected of them either.
        """
        if parameter in self._shapes:
            defect = state - self._state_at(parameter)
            before = self.defects[-MEMORY + 1 :] if self._is_as_predicted else []
            self.defects, self._is_as_predicted = [*before, (parameter, defect)], False
            self.is_trusted = True

    def _state_at(self, parameter: float) -> State:
        """Return the state made of a shape, with the natural states of its parameter."""
        if parameter not in self._states:
            self._states[parameter] = self._extrude(self._shapes[parameter])
        return self._states[parameter]

    def _defect_at(self, parameter: float) -> Array:
        """Return the defect extrapolated from the last ones; zero if there is none."""
        defect = np.zeros_like(self._newton.solid.unknown.x.array)
        weights = extrapolation_weights([t for t, _ in self.defects], parameter)
        for weight, (_, known) in zip(weights, self.defects, strict=True):
            defect += weight * known
        return defect
