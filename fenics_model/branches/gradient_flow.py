"""Gradient flow: a viscous flow at fixed load to a stable equilibrium, if none is near.

The displacement obeys c M du/dt = -dE/du, the pressures stay in balance (a viscous regularisation;
backward Euler in time). Each time step solves R(u, p) + k M (u - u_previous) = 0 with k = c / dt.
A step counts only if its tangent has no unstable mode: then it went downhill, and k may fall to
zero on a stable branch alone. The pseudo-time has no meaning, so its step grows as long as it can
(pseudo-transient continuation: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523).
"""

from dataclasses import dataclass, replace

import numpy as np

from fenics_model.branches.stability import unstable_modes
from fenics_model.solid.state import State
from fenics_model.solve.effort import Effort
from fenics_model.solve.factors import Factors
from fenics_model.solve.newton import Newton, NewtonOutcome


@dataclass(frozen=True)
class FlowRule:
    """Control of the time step of a flow, and when the flow ends.

    Parameters
    ----------
    step_limit : int
        Time steps after which it has failed.
    growth, growth_after_cut, cut : float
        Factors of the time step after a success (less once a step has failed) and after a failure.
    stiffest : float
        k over the first one beyond which a failing time step is no longer cut.
    slow : float
        The flow is nearly at rest: its viscous force over the reference.
    step_accuracy : float
        To what part of its start the residual falls in a time step.
    """

    step_limit: int = 100
    growth: float = 4.0
    growth_after_cut: float = 2.0
    cut: float = 6.0
    stiffest: float = 1e8
    slow: float = 1e-3
    step_accuracy: float = 1e-3


@dataclass(frozen=True, eq=False)
class FlowOutcome:
    """The end of a flow.

    Parameters
    ----------
    state : State
        Where it came to.
    equilibrium : NewtonOutcome or None
        The solution without viscosity that ended it; None if it found no stable equilibrium.
    effort : Effort
        What it took.
    """

    state: State
    equilibrium: NewtonOutcome | None
    effort: Effort


@dataclass(frozen=True, eq=False)
class _Step:
    """A time step: where it ended, what it took, and its viscous force, N; None if it failed.

    The factors are those of its end, which showed that it went downhill.
    """

    state: State
    effort: Effort
    force: float | None = None
    factors: Factors | None = None


class GradientFlow:
    """Flows from a state to a stable equilibrium, at the loads of the moment.

    Parameters
    ----------
    newton : Newton
        Solves each time step.
    first_viscosity : float
        k of the first time step, Pa/m2; it grows and falls from there.
    rule : FlowRule
        Its steps.
    """

    def __init__(
        self, newton: Newton, *, first_viscosity: float, rule: FlowRule | None = None
    ) -> None:
        self._newton, self._first = newton, first_viscosity
        self._rule = FlowRule() if rule is None else rule

    def flow_to_equilibrium(
        self, start: State, tolerance: float, reference: float, *, step_limit: int | None = None
    ) -> FlowOutcome:
        """Flow until the solution without viscosity is found, and stable.

        Parameters
        ----------
        start : State
            Where the flow starts.
        tolerance : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        step_limit : int, optional
            Less than that of the rule.
        """
        rule, state = self._rule, start
        limit = min(rule.step_limit, rule.step_limit if step_limit is None else step_limit)
        effort, k, growth, force_before = Effort(), self._first, rule.growth, np.inf
        factors: Factors | None = None
        while effort.flow_steps < limit and k <= rule.stiffest * self._first:
            step = self._take_step(state, k, tolerance, factors)
            state, effort, factors = step.state, effort + step.effort, step.factors
            if step.force is None:
                k, growth = k * rule.cut, rule.growth_after_cut
                continue
            k /= growth
            if step.force < min(force_before, rule.slow * reference):
                rest, _ = self._solve_if_stable(state, tolerance, factors)
                effort, factors = effort + Effort(rest.iterations), None
                if rest.converged:
                    return FlowOutcome(rest.state, rest, effort)
                if step.force == 0:  # at rest in an unstable equilibrium: it would stay for ever
                    break
            force_before = step.force
        return FlowOutcome(state, None, effort)

    def _take_step(
        self, state: State, k: float, tolerance: float, factors: Factors | None
    ) -> _Step:
        """Take one time step, at first with the factors of the step before; stay if it fails."""
        accuracy = self._rule.step_accuracy * max(tolerance, self._newton.residual_norm(state))
        with self._newton.slow_down(k, state) as viscosity:
            outcome, last = self._solve_if_stable(state, accuracy, factors)
            effort = Effort(outcome.iterations, flow_steps=1)
            if not outcome.converged:
                return _Step(state, effort)
            force, work = viscosity.norm_and_work(outcome.state)
        return _Step(outcome.state, replace(effort, dissipated=work), force, last)

    def _solve_if_stable(
        self, guess: State, tolerance: float, factors: Factors | None
    ) -> tuple[NewtonOutcome, Factors | None]:
        """Solve; a solution whose tangent has an unstable mode has not converged.

        A factorisation that does not show the modes (-1) counts as stable. The factors of the
        solution are good for the next time step, too.
        """
        outcome = self._newton.solve(guess, tolerance, factors)
        if not outcome.converged:
            return outcome, None
        last = self._newton.factorise(outcome.state)
        unstable = unstable_modes(last, self._newton.solid.number_of_pressures)
        if unstable > 0:
            return replace(outcome, converged=False, reason=f"{unstable} unstable modes"), None
        return outcome, last
