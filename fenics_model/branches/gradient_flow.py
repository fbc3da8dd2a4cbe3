"""Gradient flow: a viscous flow at fixed load to a stable equilibrium, if none is near.

The displacement obeys c M du/dt = -dE/du, the pressures stay in balance (a viscous regularisation;
backward Euler in time). Each time step solves R(u, p) + k M (u - u_previous) = 0 with k = c / dt,
by corrections with one factor of its tangent. That must have no unstable mode, and the energy must
fall by what the viscosity takes: then the step went downhill. A step that is not solved to the end
counts as well, because the pseudo-time has no meaning. So k falls as long as the steps go downhill,
and to zero near an equilibrium; it grows where they do not. A step costs one factorisation. It
begins ahead on the way of the step before: a thin body bends along a curve, and the longest step is
the one whose start is not yet stretched too much.

Sources: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523 (pseudo-transient
continuation); the energy as judge makes it a trust-region method: N. I. M. Gould, S. Lucidi,
M. Roma, Ph. L. Toint, SIAM J. Optim. 9 (1999) 504-525.
"""

import math
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from fenics_model.branches.condensed_energy import CondensedEnergy, PressureBalance
from fenics_model.branches.stability import unstable_modes
from fenics_model.solid.state import State
from fenics_model.solve.corrections import CorrectionRule
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

Array = NDArray[np.float64]


@dataclass(frozen=True)
class FlowRule:
    """Control of the time step of a flow, and when the flow ends.

    Parameters
    ----------
    step_limit : int
        Time steps after which it has failed.
    easy, hard : int
        Corrections up to which a time step is an easy one, and from which on it is a hard one.
    easy_growth, growth, hard_growth : float
        Factors of the time step after an easy one, another, and a hard one.
    growth_after_cut : float
        Largest factor of the time step after a failure.
    recovery, quick_recovery : float
        Factors by which that grows with each success, and with an easy one.
    cut, cut_several, cut_many : float
        Factors by which k grows after a failure, and after one with more than `several` or `many`
        unstable modes.
    several, many : int
        Unstable modes.
    stiffest : float
        k over the first one beyond which a failing time step is no longer cut.
    slow : float
        The flow is nearly at rest: its viscous force over the reference.
    retry : float
        Factor by which k falls until a flow without viscosity is tried again.
    ahead : float
        How far a time step begins ahead of its start, over the step before, at most.
    step_accuracy : float
        To what part of its start the residual falls in a time step.
    energy_noise : float
        Relative change of the energy that may be round-off.
    corrections : CorrectionRule
        Of a time step; its residual may grow at first, because the energy is the judge.
    """

    step_limit: int = 100
    easy: int = 6
    hard: int = 12
    easy_growth: float = 16.0
    growth: float = 6.0
    hard_growth: float = 2.0
    growth_after_cut: float = 1.5
    recovery: float = 1.25
    quick_recovery: float = 3.0
    cut: float = 4.0
    cut_several: float = 25.0
    cut_many: float = 625.0
    several: int = 2
    many: int = 6
    stiffest: float = 1e8
    slow: float = 1e-3
    retry: float = 30.0
    ahead: float = 2.0
    step_accuracy: float = 1e-3
    energy_noise: float = 1e-9
    corrections: CorrectionRule = field(
        default_factory=lambda: CorrectionRule(tangent_cost=30.0, fewest=8)
    )

    def growth_after(self, corrections: int) -> float:
        """Return the factor of the time step after one that was solved."""
        if corrections <= self.easy:
            return self.easy_growth
        return self.growth if corrections < self.hard else self.hard_growth

    def cut_after(self, modes: int) -> float:
        """Return the factor of k after a failure with some unstable modes."""
        if modes > self.many:
            return self.cut_many
        return self.cut_several if modes > self.several else self.cut


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
    unstable : NewtonOutcome or None
        The solution that ended it, if that is an unstable equilibrium.
    """

    state: State
    equilibrium: NewtonOutcome | None
    effort: Effort
    unstable: NewtonOutcome | None = None


@dataclass(frozen=True)
class ViscosityControl:
    """The k of the next time step.

    Parameters
    ----------
    rule : FlowRule
        Its factors.
    k : float
        Viscosity over time step, Pa/m2; 0 where the flow is tried without.
    last : float
        The k that a time step without viscosity goes back to if it fails.
    least : float
        The k from which on no step without viscosity is tried: one has failed there.
    most_growth : float
        Factor by which the time step grows at most; little after a failure.

    Examples
    --------
    >>> control = ViscosityControl(FlowRule(), k=1.0, last=1.0)
    >>> control.after_success(corrections=20, is_nearly_at_rest=False).k
    0.5
    >>> control.after_success(corrections=20, is_nearly_at_rest=True).k
    0.0
    >>> control.after_failure(modes=1).k
    4.0
    """

    rule: FlowRule
    k: float
    last: float
    least: float = math.inf
    most_growth: float = math.inf

    def after_success(self, corrections: int, is_nearly_at_rest: bool) -> "ViscosityControl":
        """Return the control after a time step that was solved."""
        if self.k == 0:
            return self
        less = self.k / min(self.rule.growth_after(corrections), self.most_growth)
        is_tried = is_nearly_at_rest and less < self.least
        is_easy = corrections <= self.rule.easy
        growth = self.most_growth * (self.rule.quick_recovery if is_easy else self.rule.recovery)
        return replace(self, k=0.0 if is_tried else less, last=less, most_growth=growth)

    def after_part(self, is_nearer: bool) -> "ViscosityControl":
        """Return the control after a time step that went downhill, but was not solved."""
        return self if self.k > 0 or is_nearer else self._with_viscosity()

    def after_failure(self, modes: int) -> "ViscosityControl":
        """Return the control after a time step that did not go downhill.

        Parameters
        ----------
        modes : int
            Unstable modes of its tangent; several need much more viscosity.
        """
        if self.k == 0:
            return self._with_viscosity()
        more = self.k * self.rule.cut_after(modes)
        return replace(self, k=more, last=more, most_growth=self.rule.growth_after_cut)

    def _with_viscosity(self) -> "ViscosityControl":
        return replace(self, k=self.last, least=self.last / self.rule.retry)


@dataclass(frozen=True, eq=False)
class _Place:
    """A state of the flow, its energy, J, and the norm of its residual, N."""

    state: State
    energy: float
    residual: float

    @classmethod
    def at(cls, state: State, balance: PressureBalance, newton: Newton) -> "_Place":
        return cls(state, balance.energy(state), newton.residual_norm(state))


@dataclass(frozen=True, eq=False)
class _Motion:
    """The change of state in a time step, and the k of that step."""

    change: Array
    k: float

    def ahead(self, k: float, most: float) -> Array:
        """Return what the same velocity gives in a step with another k, times `most` at most."""
        return min(most, self.k / k) * self.change


@dataclass(frozen=True, eq=False)
class _Step:
    """A time step, as far as it came.

    Parameters
    ----------
    modes : int
        Unstable modes of its tangent.
    outcome : NewtonOutcome or None
        Its solution; None if the tangent is not stable.
    end : _Place or None
        Where it ended; None if the tangent is not stable.
    force, work : float
        Norm of the viscous force at its end, N, and what the viscosity took, J.
    """

    modes: int
    outcome: NewtonOutcome | None = None
    end: _Place | None = None
    force: float = 0.0
    work: float = 0.0


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
        self._energy = CondensedEnergy(newton)

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
        rule, effort = self._rule, Effort()
        limit = min(rule.step_limit, rule.step_limit if step_limit is None else step_limit)
        control = ViscosityControl(rule, self._first, self._first)
        with self._energy.at_present_loads() as balance:
            here, motion = _Place.at(start, balance, self._newton), None
            while effort.flow_steps < limit and control.k <= rule.stiffest * self._first:
                left = here.residual / tolerance
                self._newton.tell(
                    f"viscous flow, step {effort.flow_steps + 1}, residual {left:.1e} of what is "
                    "accepted"
                )
                step = self._take_step(here, motion, control.k, tolerance, balance)
                effort += Effort(1, flow_steps=1)
                outcome, end = step.outcome, step.end
                if outcome is None or end is None or not self._went_down(here, end, step.work):
                    control = control.after_failure(step.modes)
                    continue
                effort += Effort(dissipated=step.work)
                if control.k > 0 and outcome.corrections == 0 and motion is None:
                    break  # at rest in an unstable equilibrium: it would stay for ever
                if control.k == 0 and outcome.converged:
                    return self._end(outcome, effort)
                motion = None
                if outcome.converged:
                    if control.k > 0 and outcome.corrections > 0:
                        motion = _Motion(end.state - here.state, control.k)
                    is_slow = step.force < rule.slow * reference
                    control = control.after_success(outcome.corrections, is_slow)
                else:
                    control = control.after_part(end.residual < here.residual / 2)
                here = end
        return FlowOutcome(here.state, None, effort)

    def _take_step(
        self,
        here: _Place,
        motion: _Motion | None,
        k: float,
        tolerance: float,
        balance: PressureBalance,
    ) -> _Step:
        """Take one time step, with one factorisation, from where the last motion leads."""
        guess = here.state
        if k and motion is not None:
            guess = self._newton.reach(guess, guess + motion.ahead(k, self._rule.ahead))
        with ExitStack() as stack:
            viscosity = stack.enter_context(self._newton.slow_down(k, here.state)) if k else None
            factors = self._newton.factorise(guess)
            modes = unstable_modes(factors, self._newton.solid.number_of_pressures)
            if factors.failure or modes > 0:
                return _Step(modes)
            outcome = self._newton.solve(
                guess,
                self._rule.step_accuracy * here.residual if k else tolerance,
                factors,
                iteration_limit=0,
                rule=self._rule.corrections,
            )
            held_back = (0.0, 0.0)
            if viscosity is not None:
                held_back = viscosity.norm_and_work(outcome.state)
        end = _Place.at(outcome.state, balance, self._newton)
        return _Step(modes, outcome, end, *held_back)

    def _went_down(self, here: _Place, there: _Place, work: float) -> bool:
        """Whether the energy fell by what the viscosity has taken at least; NaN did not."""
        noise = self._rule.energy_noise * abs(here.energy)
        return there.energy + work / 2 <= here.energy + noise

    def _end(self, outcome: NewtonOutcome, effort: Effort) -> FlowOutcome:
        """Return the outcome at rest, where the flow ends even if it is not stable."""
        with self._newton.factorise(outcome.state) as factors:
            modes = unstable_modes(factors, self._newton.solid.number_of_pressures)
        if modes > 0:
            return FlowOutcome(outcome.state, None, effort, unstable=outcome)
        return FlowOutcome(outcome.state, outcome, effort)
