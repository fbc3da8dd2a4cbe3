"""A load path without time: the equilibria of a shell at its targets, each from the one before.

A target is tried in one step from the last equilibrium, the first one from flat or from a shape
that is given: the load grows over the first iterations and Newton's method goes on from there. If
it fails, the load goes there in smaller steps. An equilibrium with unstable modes is left along one
of them (`dshell.release.branches`), so no imperfection is needed; a bilayer bends by itself.

A load is a tuple of numbers, such as the two stretches of a specimen or the share of a pressure:
nothing here knows what they are.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from dshell.energies.assembly import Assembly
from dshell.release.branches import BranchRule
from dshell.release.effort import NO_EFFORT, ShellEffort
from dshell.solve.linear_solver import LinearSolver
from dshell.solve.newton import Body, EquilibriumSolver, NewtonLimits, Outcome

Array = NDArray[np.float64]
Load = TypeVar("Load", bound=tuple[float, ...])


class ShellProblem(Protocol[Load]):
    """A shell under loads: a body for each of them, on the same degrees of freedom."""

    @property
    def unloaded(self) -> Load:
        """The load of the flat state that a path begins with."""

    @property
    def held(self) -> NDArray[np.int64]:
        """Degrees of freedom that do not change."""

    @property
    def least_force(self) -> float:
        """Force that tolerances are at least relative to, N, so that round-off is above them."""

    def way(self, start: Load, end: Load) -> float:
        """Return the way between two loads, which `StepLimits.ramp` divides."""

    def name_of(self, load: Load) -> str:
        """Return a load in a few words."""

    def flat(self, load: Load) -> Array:
        """Return the flat state under a load, m, shape (dofs,)."""

    def body(self, load: Load) -> Body:
        """Return the shell under a load, always on the same stencils."""


@dataclass(frozen=True)
class StepLimits:
    """Size of the steps of a path, and tolerance of its equilibria.

    Parameters
    ----------
    tolerance : float
        Norm of the residual force, over that of the flat state.
    iterations : int
        Newton iterations allowed in one load step.
    longest_step : float
        Largest change of a degree of freedom in one iteration, m.
    ramp : float
        Growth of the load in each of the first iterations of a load step; infinite: at once.
    smallest_step : float
        Smallest load step that is tried, over the way to the target.
    """

    tolerance: float
    iterations: int
    longest_step: float
    ramp: float = math.inf
    smallest_step: float = 1.0


@dataclass(frozen=True, eq=False)
class ShellState(Generic[Load]):
    """A state of a shell on its path.

    Parameters
    ----------
    load : tuple of float
        What it is under.
    state : (dofs,) array of float
        All degrees of freedom, m.
    residual : float
        Norm of the residual force over that of the flat state.
    unstable_modes : int or None
        How many it has; None if nobody has counted them.
    share : float
        Part of the way to the target, 1 at it.
    effort : ShellEffort
        The work since the state before.
    """

    load: Load
    state: Array
    residual: float = 0.0
    unstable_modes: int | None = None
    share: float = 0.0
    effort: ShellEffort = NO_EFFORT


class StaticPath(Generic[Load]):
    """A shell that goes from equilibrium to equilibrium; see `bilayer.solvers.contract.Path`.

    Parameters
    ----------
    problem : ShellProblem
        The shell and its loads.
    limits : StepLimits
        Tolerances and limits.
    solver : EquilibriumSolver
        Of the shell, see `equilibrium_solver`.
    branch : BranchRule
        Finds the equilibrium of a load step.
    """

    def __init__(
        self,
        problem: ShellProblem[Load],
        limits: StepLimits,
        solver: EquilibriumSolver,
        branch: BranchRule,
    ) -> None:
        self._problem, self._limits = problem, limits
        self._solver, self._branch_rule = solver, branch
        self._here = ShellState(problem.unloaded, problem.flat(problem.unloaded))
        self._effort = ShellEffort()

    def stopped(self) -> ShellState[Load]:
        """Return the last state, with the work done in vain since."""
        return replace(self._here, effort=self._spent())

    def move_to(self, state: ShellState[Load], effort: ShellEffort | None = None) -> None:
        """Go on from a state that is known, having done some work already."""
        self._here = state
        if effort is not None:
            self._effort += effort

    def begin_near(self, guess: Array, load: Load, iterations: int) -> bool:
        """Go to the equilibrium near a guess; return whether it is soon found.

        A guess that passes through itself leads nowhere if the shell may not.
        """
        contact = self._problem.body(load).contact
        if contact is not None and contact.is_crossed(guess):
            return False
        few = min(iterations, self._limits.iterations)
        body = self._problem.body(load)
        try:
            limits = self._newton_limits(self._force_scale(body, load), few)
            smooth = self._solver.smooth_guess(body, guess, limits)
            self._effort += ShellEffort(1, 0)
            found = self._equilibrium(ShellState(load, smooth), load, few)
        except ComputationError:
            return False
        if isinstance(found, ShellState):
            self._here = found
        return isinstance(found, ShellState)

    def approach(self, target: Load) -> Iterator[ShellState[Load]]:
        """Go to a load, in one step if that works.

        Yields
        ------
        ShellState
            Each equilibrium on the way; the last is at the target.

        Raises
        ------
        ComputationError
            The smallest step fails, too.
        """
        start = replace(self._here, share=0.0)
        if start.load == target and start.unstable_modes is not None:
            yield self._arrived(start, 1.0)
            return
        share, step = 0.0, 1.0
        while share < 1:
            end = min(1.0, share + step)
            load = between(start.load, target, end)
            found = self._equilibrium(self._here, load, self._limits.iterations)
            if isinstance(found, ShellState):
                share = end
                yield self._arrived(found, share)
            elif step / 2 < self._limits.smallest_step:
                place = self._problem.name_of(load)
                raise ComputationError(
                    f"Newton's method did not converge: residual {found.residual:.3g} N "
                    f"after {found.iterations} iterations, in a step to {place}"
                )
            else:
                step /= 2

    def limits_at(self, load: Load, iterations: int) -> NewtonLimits:
        """Return the limits of a search for equilibria under a load."""
        few = min(iterations, self._limits.iterations)
        return self._newton_limits(self.force_scale_at(load), few)

    def force_scale_at(self, load: Load) -> float:
        """Return the force that residuals under a load are relative to, N."""
        return self._force_scale(self._problem.body(load), load)

    def _arrived(self, found: ShellState[Load], share: float) -> ShellState[Load]:
        self._here = replace(found, share=share, effort=self._spent())
        return self._here

    def _spent(self) -> ShellEffort:
        """Return the work since the last call."""
        effort, self._effort = self._effort, ShellEffort()
        return effort

    def _equilibrium(
        self, here: ShellState[Load], load: Load, iterations: int
    ) -> ShellState[Load] | Outcome:
        """Settle under a load; return the outcome as it is if that fails."""
        body = self._problem.body(load)
        scale = self._force_scale(body, load)
        limits = self._newton_limits(scale, iterations)
        bodies = self._ramp(here.load, body, load)
        found = self._branch_rule.take_load_step(bodies, here.state, here.unstable_modes, limits)
        outcome = found.outcome
        self._effort += ShellEffort(outcome.iterations, 1)
        if not outcome.converged:
            return outcome
        return ShellState(load, outcome.state, outcome.residual / scale, found.unstable_modes)

    def _newton_limits(self, scale: float, iterations: int) -> NewtonLimits:
        """Return the limits of a solve, its tolerance relative to a force, N."""
        return NewtonLimits(self._limits.tolerance * scale, iterations, self._limits.longest_step)

    def _ramp(self, start: Load, body: Body, end: Load) -> list[Body]:
        """Return the shell on its way to a load, one body per iteration, and at its end."""
        count = math.ceil(self._problem.way(start, end) / self._limits.ramp)
        shares = np.arange(1, count) / count
        on_the_way = (self._problem.body(between(start, end, float(share))) for share in shares)
        return [*on_the_way, body]

    def _force_scale(self, body: Body, load: Load) -> float:
        """Return the force that the tolerance is relative to, N: that on the flat state."""
        weightless = Body(body.energies, 0 * body.load)
        flat = self._solver.configure(weightless, self._problem.flat(load))
        if not math.isfinite(flat.error):
            place = self._problem.name_of(load)
            raise ComputationError(
                f"the flat sheet is out of reach at {place}: the law of a layer locks"
            )
        return max(flat.error + float(np.linalg.norm(body.load)), self._problem.least_force)


def equilibrium_solver(
    problem: ShellProblem[Load], linear_solver: LinearSolver
) -> EquilibriumSolver:
    """Return the solver for the equilibria of a shell."""
    flat, body = problem.flat(problem.unloaded), problem.body(problem.unloaded)
    return EquilibriumSolver(Assembly(len(flat), body.energies, problem.held), linear_solver)


def between(start: Load, end: Load, share: float) -> Load:
    """Return the load at a share of the way; the end itself at 1."""
    if share == 1:
        return end
    return cast(Load, tuple(a + share * (b - a) for a, b in zip(start, end, strict=True)))
