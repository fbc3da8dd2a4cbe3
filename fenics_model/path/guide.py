"""Load steps that another result's shapes predict, straight from one shape to the next.

A shape of the guide, made a state of the solid, differs from the solid's equilibrium by a defect.
The defect at the next parameter is extrapolated from the last three and added to the guide's state.
This is the initial guess of Newton's method. If the solution is far from the guess, it is on
another branch, and the step is rejected. If there is no solution, the body flows from the guess to
a stable equilibrium; if it finds none, the step is rejected. From a guess with elements inside out
no flow can begin. Then it flows from the last equilibrium, at the loads of the next.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.results.starting import LONGEST_WAY
from fenics_model.branches.gradient_flow import FlowOutcome, GradientFlow
from fenics_model.path.predictor import MEMORY, extrapolation_weights
from fenics_model.solid.state import State
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
    iteration_limit: int = 6
    flow_steps: int = 100
    further_flows: int = 3


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
        guess = self._state_at(there) + self._defect_at(there)
        outcome, effort = None, Effort(guided_steps=1)
        near = self._rule.far_from_balance * reference
        if self._newton.residual_norm(guess) < near:  # else far, or no number
            outcome = self._solve(guess, accepted)
            effort += Effort(outcome.iterations)
        if outcome is None or not outcome.converged:
            relaxed, iterations = self._relax(there, guess, reference)
            effort += Effort(iterations)
            guess, outcome = relaxed.state, relaxed
            if relaxed.converged:
                outcome = self._solve(guess, accepted)
                effort += Effort(outcome.iterations)
        self._guess = guess
        if outcome.converged and self._is_far_from_guess(before, guess, outcome.state):
            outcome = replace(outcome, converged=False, reason="another branch")
        if outcome.converged:
            return outcome, effort
        if not np.isfinite(self._newton.residual_norm(guess)):
            self._guess = before  # the shape has folds in which elements are inside out
        flowed = self.flow_from_shape(there, accepted, reference, outcome.reason)
        effort += flowed.effort
        return (outcome if flowed.equilibrium is None else flowed.equilibrium), effort

    def _relax(self, there: float, guess: State, reference: float) -> tuple[NewtonOutcome, int]:
        """Return a guess relaxed with its surface held, and the iterations that this took.

        If that fails, the defect is no good, and the shape alone is relaxed. If that fails, too,
        the shape is returned as it is, from which Newton's method need not be tried.
        """
        tolerance = self._rule.relaxed_residual * reference
        relaxed = self._relax_guess(guess, tolerance)
        if relaxed.converged:
            return relaxed, relaxed.iterations
        shape = self._state_at(there)
        alone = self._relax_guess(shape, tolerance)
        iterations = relaxed.iterations + alone.iterations
        return (alone if alone.converged else replace(alone, state=shape)), iterations

    def _solve(self, guess: State, accepted: float) -> NewtonOutcome:
        return self._newton.solve(guess, accepted, iteration_limit=self._rule.iteration_limit)

    def flow_from_shape(
        self, there: float, accepted: float, reference: float, reason: str
    ) -> FlowOutcome:
        """Flow to a stable equilibrium from the guess of the last step, which did not lead to one.

        The shape is rejected if that fails, too, for the reason why the step did.
        """
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
        """Record the defect of the shape at a parameter, if there is one."""
        if parameter in self._shapes:
            defect = state - self._state_at(parameter)
            self.defects = [*self.defects[-MEMORY + 1 :], (parameter, defect)]
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
