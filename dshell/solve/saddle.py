"""Newton's method for an unstable equilibrium that is near, with corrections by the same factor.

A straight step that turns a thin shell also stretches it. Corrections with the factor that is there
take the stretch out again; without them Newton's method leaves a saddle that is not very near.
"""

import numpy as np

from dshell.solve.linear_solver import SingularMatrixError
from dshell.solve.newton import (
    Array,
    Body,
    Configuration,
    EquilibriumSolver,
    Factor,
    NewtonLimits,
    Outcome,
)

GROWTH = 3.0
"""Of the residual force over a step and its corrections; more, and half of the step is tried."""
HALVINGS = 5
LESS = 0.7
"""Share of the residual force that a correction leaves at most, or it ends the corrections."""


def find_saddle(
    solver: EquilibriumSolver, body: Body, start: Array, limits: NewtonLimits
) -> Outcome:
    """Go to an equilibrium near a state by Newton steps, stable or not.

    Parameters
    ----------
    solver : EquilibriumSolver
        Of the body.
    body : Body
        What is in equilibrium.
    start : (dofs,) array of float
        The first state, m.
    limits : NewtonLimits
        When to stop.
    """
    here = solver.configure(body, start)
    for iteration in range(limits.iterations + 1):
        converged = here.error <= limits.tolerance
        if converged or not np.isfinite(here.error) or iteration == limits.iterations:
            break
        try:
            factor = solver.factor(here.hessian())
        except SingularMatrixError:
            break
        here = _stepped(solver, here, factor, limits)
    return Outcome(here.state, converged, here.error, iteration)


def _stepped(
    solver: EquilibriumSolver, here: Configuration, factor: Factor, limits: NewtonLimits
) -> Configuration:
    """Return the body after a step and its corrections, shortened if its forces grow."""
    step = _step(solver, here, factor, limits)
    for halving in range(HALVINGS):
        there = here.moved(step / 2**halving)
        for _ in range(limits.corrections):
            corrected = there.moved(_step(solver, there, factor, limits))
            if not corrected.error < LESS * there.error:
                break
            there = corrected
        if there.error < GROWTH * here.error:
            break
    return there


def _step(
    solver: EquilibriumSolver, here: Configuration, factor: Factor, limits: NewtonLimits
) -> Array:
    step = np.zeros(solver.assembly.size)
    step[solver.assembly.free] = -factor.solve(here.residual)
    length = np.abs(step).max()
    return step * min(1.0, limits.longest_step / length) if length > 0 else step
