"""Gradient flow: a viscous flow at fixed load to a stable equilibrium, if none is near.

The displacement obeys c M du/dt = -dE/du, the pressures stay in balance (a viscous regularisation;
backward Euler in time). Each time step solves R(u, p) + k M (u - u_previous) = 0 with k = c / dt.
Its first tangent must have no unstable mode, and the energy must fall by what the viscosity takes:
then the step went downhill. A step that is not solved to the end counts as well, because the
pseudo-time has no meaning. So k falls as long as the steps go downhill, and to zero near an
equilibrium; it grows where they do not.

A thin body bends along a curve. On its tangent it stretches, and what a step's first tangent knows
is wrong from there on. A second one, its stress extrapolated from the start, takes that stretch
away again (`solid.tangent`). So a step of two or three tangents goes many times as far as one that
keeps to the first.

Sources: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523 (pseudo-transient
continuation); the energy as judge makes it a trust-region method: N. I. M. Gould, S. Lucidi,
M. Roma, Ph. L. Toint, SIAM J. Optim. 9 (1999) 504-525.
"""

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace

from fenics_model.branches.buckling_modes import BucklingMode, buckling_modes
from fenics_model.branches.condensed_energy import CondensedEnergy, PressureBalance
from fenics_model.branches.stability import unstable_modes
from fenics_model.solid.state import State
from fenics_model.solve.corrections import CorrectionRule
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
    tangents : int
        Of a time step at most.
    easy, hard : int
        Tangents up to which a time step is an easy one, and from which on it is a hard one.
    easy_growth, growth, hard_growth : float
        Factors of the time step after an easy one, another, and a hard one.
    growth_after_cut : float
        Largest factor of the time step after a failure.
    recovery, quick_recovery : float
        Factors by which that grows with each success, and with one that is not hard.
    cut, cut_several, cut_many : float
        Factors by which k grows after a failure, and after one with more than `several` or `many`
        unstable modes.
    several, many : int
        Unstable modes.
    beyond : float
        k beyond the one at which the most unstable mode would be neither stable nor unstable, over
        what is missing up to there. Of several modes at most; more are not computed.
    stiffest : float
        k over the first one beyond which a failing time step is no longer cut.
    slow : float
        The flow is nearly at rest: its viscous force over that at the end of the step before.
    shorter : float
        The same of the way of a step.
    retry : float
        Factor by which k falls until a flow without viscosity is tried again.
    step_accuracy : float
        To what part of its start the residual falls in a time step.
    energy_noise : float
        Relative change of the energy that may be round-off.
    halvings : int
        How often the distance is halved at which an unstable equilibrium is left.
    corrections : CorrectionRule
        Of a time step; its residual may grow at first, because the energy is the judge.
    """

    step_limit: int = 100
    tangents: int = 4
    easy: int = 1
    hard: int = 3
    easy_growth: float = 30.0
    growth: float = 10.0
    hard_growth: float = 3.0
    growth_after_cut: float = 1.5
    recovery: float = 1.25
    quick_recovery: float = 2.0
    cut: float = 4.0
    cut_several: float = 25.0
    cut_many: float = 625.0
    several: int = 6
    many: int = 20
    beyond: float = 2.0
    stiffest: float = 1e8
    slow: float = 0.2
    shorter: float = 0.7
    retry: float = 10.0
    step_accuracy: float = 0.1
    energy_noise: float = 1e-9
    halvings: int = 5
    corrections: CorrectionRule = field(
        default_factory=lambda: CorrectionRule(tangent_cost=12.0, window=2, fewest=1, fruitless=0.3)
    )

    def growth_after(self, tangents: int) -> float:
        """Return the factor of the time step after one that was solved."""
        if tangents <= self.easy:
            return self.easy_growth
        return self.growth if tangents < self.hard else self.hard_growth

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
    >>> control.after_success(tangents=2, is_nearly_at_rest=False).k
    0.1
    >>> control.after_success(tangents=2, is_nearly_at_rest=True).k
    0.0
    >>> control.after_failure(modes=0).k
    4.0
    >>> control.after_failure(modes=1, missing=3.0).k
    7.0
    """

    rule: FlowRule
    k: float
    last: float
    least: float = math.inf
    most_growth: float = math.inf

    def after_success(self, tangents: int, is_nearly_at_rest: bool) -> "ViscosityControl":
        """Return the control after a time step that was solved."""
        if self.k == 0:
            return self
        less = self.k / min(self.rule.growth_after(tangents), self.most_growth)
        is_tried = is_nearly_at_rest and less < self.least
        is_hard = tangents >= self.rule.hard
        growth = self.most_growth * (self.rule.recovery if is_hard else self.rule.quick_recovery)
        return replace(self, k=0.0 if is_tried else less, last=less, most_growth=growth)

    def after_part(self, is_nearer: bool) -> "ViscosityControl":
        """Return the control after a time step that went downhill, but was not solved."""
        return self if self.k > 0 or is_nearer else self._with_viscosity()

    def after_failure(self, modes: int, missing: float | None = None) -> "ViscosityControl":
        """Return the control after a time step that did not go downhill.

        Parameters
        ----------
        modes : int
            Unstable modes of its tangent; many need much more viscosity.
        missing : float, optional
            What k lacks until the most unstable one is none, if it is known.
        """
        if missing is not None:
            more = self.k + self.rule.beyond * missing
            least = self.least if self.k > 0 else more / self.rule.retry
        elif self.k == 0:
            return self._with_viscosity()
        else:
            more, least = self.k * self.rule.cut_after(modes), self.least
        return replace(self, k=more, last=more, least=least, most_growth=self.rule.growth_after_cut)

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
class _Step:
    """A time step, as far as it came.

    Parameters
    ----------
    modes : int
        Unstable modes of its first tangent.
    mode : BucklingMode or None
        The most unstable one of them, if it is known.
    outcome : NewtonOutcome or None
        Its solution; None if the tangent is not stable.
    end : _Place or None
        Where it ended; None if the tangent is not stable.
    force, work : float
        Norm of the viscous force at its end, N, and what the viscosity took, J.
    """

    modes: int
    mode: BucklingMode | None = None
    outcome: NewtonOutcome | None = None
    end: _Place | None = None
    force: float = 0.0
    work: float = 0.0

    @property
    def missing(self) -> float | None:
        """See `ViscosityControl.after_failure`."""
        return None if self.mode is None else -self.mode.stiffness

    @property
    def tangents(self) -> int:
        """Number of tangents that it took."""
        return 1 if self.outcome is None else 1 + self.outcome.iterations


class GradientFlow:
    """Flows from a state to a stable equilibrium, at the loads of the moment.

    Parameters
    ----------
    newton : Newton
        Solves each time step.
    first_viscosity : float
        k of the first time step, Pa/m2; it grows and falls from there.
    escape : float
        Distance by which an unstable equilibrium is left, m, rms over the body.
    rule : FlowRule
        Its steps.
    """

    def __init__(
        self,
        newton: Newton,
        *,
        first_viscosity: float,
        escape: float,
        rule: FlowRule | None = None,
    ) -> None:
        self._newton, self._first, self._escape = newton, first_viscosity, escape
        self._rule = FlowRule() if rule is None else rule
        self._energy = CondensedEnergy(newton)

    def lowest(self, states: Sequence[State]) -> State:
        """Return the state of least energy, the last one if none has an energy."""
        with self._energy.at_present_loads() as balance:
            energies = [balance.energy(state) for state in states]
        finite = [one for one in range(len(states)) if math.isfinite(energies[one])]
        return states[min(finite, key=lambda one: energies[one], default=-1)]

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
            here, way = _Place.at(start, balance, self._newton), 0.0
            is_first = True
            while effort.flow_steps < limit and control.k <= rule.stiffest * self._first:
                left = here.residual / tolerance
                self._newton.tell(
                    f"viscous flow, step {effort.flow_steps + 1}, residual {left:.1e} of what is "
                    "accepted"
                )
                step = self._take_step(here, control.k, tolerance, balance)
                effort += Effort(step.tangents, flow_steps=1)
                outcome, end = step.outcome, step.end
                if outcome is None or end is None or not self._went_down(here, end, step.work):
                    control = control.after_failure(step.modes, step.missing)
                    if step.mode is not None and here.residual <= tolerance:
                        here = self._beside(here, step.mode, balance) or here
                    continue
                effort += Effort(dissipated=step.work)
                if control.k > 0 and outcome.corrections == 0 and is_first:
                    break  # at rest in an unstable equilibrium: it would stay for ever
                if control.k == 0 and outcome.converged:
                    return self._end(outcome, effort)
                is_first = False
                if outcome.converged:
                    before, way = way, self._newton.solid.displacement_norm(end.state - here.state)
                    is_slow = step.force < rule.slow * min(here.residual, reference)
                    is_at_end = is_slow and way < rule.shorter * before
                    control = control.after_success(step.tangents, is_at_end)
                else:
                    control = control.after_part(end.residual < here.residual / 2)
                here = end
        return FlowOutcome(here.state, None, effort)

    def _take_step(
        self, here: _Place, k: float, tolerance: float, balance: PressureBalance
    ) -> _Step:
        """Take one time step."""
        rule, newton = self._rule, self._newton
        with ExitStack() as stack:
            viscosity = stack.enter_context(newton.slow_down(k, here.state)) if k else None
            factors = newton.factorise(here.state)
            modes = unstable_modes(factors, newton.solid.number_of_pressures)
            if factors.failure or modes > 0:
                return _Step(modes, self.most_unstable_mode(factors, modes, here.state))
            outcome = newton.solve(
                here.state,
                # below the tolerance, too: a body that is hardly out of balance has to move on
                rule.step_accuracy * here.residual if k else tolerance,
                factors,
                iteration_limit=rule.tangents - 1,
                rule=rule.corrections,
            )
            held_back = (0.0, 0.0)
            if viscosity is not None:
                held_back = viscosity.norm_and_work(outcome.state)
        end = _Place.at(outcome.state, balance, newton)
        return _Step(modes, None, outcome, end, *held_back)

    def most_unstable_mode(self, factors: Factors, modes: int, state: State) -> BucklingMode | None:
        """Return the most unstable mode of a tangent; None if it is not known.

        The viscosity that it lacks is minus its stiffness: the mass matrix of both is the same.
        """
        if factors.failure or not 0 < modes <= self._rule.several:
            return None
        side = state - self._newton.solid.undeformed
        found = buckling_modes(factors, self._newton.mass, modes, side)
        return found[0] if found else None

    def _beside(self, rest: _Place, mode: BucklingMode, balance: PressureBalance) -> _Place | None:
        """Return a lower place to one side of an unstable equilibrium; None if neither is lower.

        A flow would leave it as slowly as an exponential grows out of round-off.
        """
        distance = self._escape
        for _ in range(self._rule.halvings):
            sides = [rest.state + sign * distance * mode.direction for sign in (1, -1)]
            places = [
                _Place.at(self._newton.reach(rest.state, side), balance, self._newton)
                for side in sides
            ]
            lower = min(places, key=lambda place: place.energy)
            if lower.energy < rest.energy:
                return lower
            distance /= 2
        return None

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
