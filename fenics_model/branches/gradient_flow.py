"""The way down where no equilibrium is near: a viscous flow to a stable one at fixed load.

The displacement obeys c M du/dt = -dE/du, the pressures stay in balance (a viscous regularisation;
backward Euler in time). Each time step solves R(u, p) + k M (u - u_previous) = 0 with k = c / dt.
A step counts only if its tangent has no unstable mode: then it went downhill, and k may fall to
zero on a stable branch alone. The pseudo-time has no meaning, so its step grows as long as it can
(pseudo-transient continuation: C. T. Kelley, D. E. Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523).
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from petsc4py import PETSc

from fenics_model.branches.stability import unstable_modes, unstable_modes_of
from fenics_model.solid.solid import Solid
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton, NewtonOutcome

GROWTH, GROWTH_AFTER_CUT, CUT = 4.0, 2.0, 6.0
"""Factors of the time step after a success (less once a step has failed) and after a failure."""

STIFFEST = 1e8
"""Where a failing time step is no longer cut: k over the first one."""

SLOW = 1e-3
"""The flow is nearly at rest: its viscous force over the reference."""

STEP_ACCURACY = 1e-3
"""To what part of its start the residual falls in a time step."""


@dataclass(frozen=True)
class FlowOutcome:
    """Where a flow ended.

    Parameters
    ----------
    equilibrium : NewtonOutcome or None
        The solution without viscosity that ended it; None if it found no stable equilibrium.
    effort : Effort
        What it took.
    """

    equilibrium: NewtonOutcome | None
    effort: Effort


class GradientFlow:
    """Flows from the solver's present state to a stable equilibrium, at the loads of the moment.

    Parameters
    ----------
    newton : Newton
        Holds the state.
    solid : Solid
        Whose displacements flow.
    first_viscosity : float
        k of the first time step, Pa/m2; it grows and falls from there.
    step_limit : int
        Time steps after which it has failed.
    """

    def __init__(
        self,
        newton: Newton,
        solid: Solid,
        *,
        first_viscosity: float,
        step_limit: int,
    ) -> None:
        self._newton, self._solid = newton, solid
        self._first, self._step_limit = first_viscosity, step_limit

    def unstable_modes(self) -> int:
        """Count the unstable modes of the present state; see `stability.unstable_modes`."""
        return unstable_modes(self._newton, self._solid.number_of_pressures)

    @cached_property
    def mass(self) -> PETSc.Mat:
        """M, zero for pressures and held dofs, m3; made when first needed, which is seldom."""
        return self._newton.assembled(self._solid.mass())

    def relax(self, tolerance: float, reference: float) -> FlowOutcome:
        """Flow until the solution without viscosity is found, and stable.

        Where that fails the state is where the flow came to.

        Parameters
        ----------
        tolerance : float
            Norm of the residual of an equilibrium, N.
        reference : float
            Norm of the residual that is to be balanced, N.
        """
        effort, k, growth, force_before = Effort(), self._first, GROWTH, np.inf
        while effort.flow_steps < self._step_limit and k <= STIFFEST * self._first:
            step, force = self._step(k, tolerance)
            effort += step
            if force is None:
                k, growth = k * CUT, GROWTH_AFTER_CUT
                continue
            k /= growth
            if force < min(force_before, SLOW * reference):
                rest = self._solve_if_stable(tolerance)
                effort += Effort(rest.iterations)
                if rest.converged:
                    return FlowOutcome(rest, effort)
            force_before = force
        return FlowOutcome(None, effort)

    def _step(self, k: float, tolerance: float) -> tuple[Effort, float | None]:
        """Take one time step; return what it took and the viscous force, None if it failed."""
        accuracy = max(tolerance, STEP_ACCURACY * self._newton.residual_norm())
        with self._newton.slowed(self.mass, k) as viscosity:
            outcome = self._solve_if_stable(accuracy)
            effort = Effort(outcome.iterations, flow_steps=1)
            if not outcome.converged:
                return effort, None
            force, work = viscosity.norm_and_work(self._newton.vector())
        return replace(effort, dissipated=work), force

    def _solve_if_stable(self, tolerance: float) -> NewtonOutcome:
        """Solve; where that fails or the tangent has an unstable mode, restore the state.

        A factorisation that does not show the modes (-1) counts as stable.
        """
        values = self._newton.state.x.array
        kept = values.copy()
        outcome = self._newton.solve(tolerance)
        unstable = unstable_modes_of(self._newton.factors, self._solid.number_of_pressures)
        if outcome.converged and unstable > 0:
            outcome = replace(outcome, converged=False, reason=f"{unstable} unstable modes")
        if not outcome.converged:
            values[:] = kept
        return outcome
