"""Release in time: the motion of the shell's mass under drag, until it rests in an equilibrium.

From each target to the next the load grows linearly over the first half of the time; in the second
half nothing changes and drag takes the motion away. Implicit Euler's time steps find their own
length (`dshell.solve.dynamics.adaptive_euler`). Nodes carry the mass; what else a model adds to the
state, such as Morley's displacements of the edges, has none and follows at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from dshell.release.branches import BranchRule
from dshell.release.effort import ShellEffort
from dshell.release.static import (
    Load,
    ShellProblem,
    ShellState,
    StaticPath,
    StepLimits,
    between,
)
from dshell.solve.dynamics import (
    AdaptiveStepping,
    ConvergenceError,
    Motion,
    MovingBody,
    NewtonRule,
    adaptive_euler,
)
from dshell.solve.newton import EquilibriumSolver

Array = NDArray[np.float64]

RAMP_SHARE_OF_TIME = 0.5
"""Share of the time in which the load grows."""
AT_REST = 1e-6
"""Force out of balance at the end, over that of the flat state, that still counts as rest."""


class MovingProblem(ShellProblem[Load], Protocol[Load]):
    """A shell with mass."""

    def masses(self, load: Load) -> Array:
        """Return the mass behind each degree of freedom under a load, kg, shape (dofs,)."""


@dataclass(frozen=True)
class MotionLimits:
    """Duration, time step and damping of a motion.

    Parameters
    ----------
    total_time : float
        From target to target, s.
    time_step : float
        The first one, s.
    damping_rate : float
        Drag per mass and velocity, 1/s.
    iterations : int
        Newton iterations allowed in one time step; a step that needs more is halved.
    """

    total_time: float
    time_step: float
    damping_rate: float
    iterations: int = 12


class DynamicPath(StaticPath[Load]):
    """The load path of a shell as a motion; see `StaticPath`.

    Parameters
    ----------
    problem : MovingProblem
        The shell, its loads and its mass.
    motion : MotionLimits
        Time and drag.
    limits, solver, branch
        As those of `StaticPath`: for the tolerance, and for a start near a shape.
    """

    def __init__(
        self,
        problem: MovingProblem[Load],
        motion: MotionLimits,
        limits: StepLimits,
        solver: EquilibriumSolver,
        branch: BranchRule,
    ) -> None:
        super().__init__(problem, limits, solver, branch)
        self._moving, self._motion = problem, motion

    def approach(self, target: Load) -> Iterator[ShellState[Load]]:
        """Move to a load and come to rest there.

        Yields
        ------
        ShellState
            The state after each time step, not at rest but for the last, which is at the target.

        Raises
        ------
        ComputationError
            The shortest time step does not converge, or the body is not at rest at the end.
        """
        start, body = self._here, self._problem.body(target)
        scale = self._force_scale(body, target)
        end = self._motion.total_time
        rule = NewtonRule(self._limits.tolerance * scale, self._motion.iterations)
        stepping = AdaptiveStepping(self._motion.time_step, end, rule)
        still = Motion(0.0, start.state, np.zeros_like(start.state))
        try:
            for motion in adaptive_euler(self._body_moving(start.load, target), still, stepping):
                self._effort += ShellEffort(motion.iterations, 1)
                load = self._load_at(start.load, target, motion.time)
                moved = self._solver.configure(self._problem.body(load), motion.position)
                self._here = ShellState(load, motion.position, moved.error / scale)
                if motion.time < end:
                    yield self._arrived(self._here, motion.time / end)
        except ConvergenceError as stop:
            self._effort += ShellEffort(stop.iterations)
            raise
        if self._here.residual > AT_REST:
            raise ComputationError(
                f"the body still moves after solver.total_time = {end:g} s: force out of balance "
                f"{self._here.residual:.1e} of that of the flat state, expected {AT_REST}"
            )
        yield self._arrived(self._here, 1.0)

    def _body_moving(self, start: Load, target: Load) -> MovingBody:
        """Return the body that moves from one load to another."""
        return MovingBody(
            self._moving.masses(target),
            self._problem.held,
            energies=lambda now: self._problem.body(self._load_at(start, target, now)).energies,
            load=lambda now: self._problem.body(self._load_at(start, target, now)).load,
            damping_rate=self._motion.damping_rate,
        )

    def _load_at(self, start: Load, target: Load, now: float) -> Load:
        return between(
            start, target, min(1.0, now / (RAMP_SHARE_OF_TIME * self._motion.total_time))
        )
