"""The motion of lumped masses under energies, a load and drag: implicit Euler with Newton-Raphson.

Positions x and velocities v at the end of a time step of length h solve

    m (v - v_old) / h + m c v + dE/dx(x, t) = f(t),    v = (x - x_old) / h,

by full Newton steps on the residual of what is free, to a tolerance on its Euclidean norm. What
has no mass follows at once. Nothing here knows what the energies are, nor why they change with
time. The step is fixed (`implicit_euler`) or finds its own length (`adaptive_euler`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from bilayer.errors import ComputationError
from bilayer.runtime.time_limit import check_time
from dshell.energies.assembly import Assembly, Energy, deform, gradient_of
from dshell.energies.whole_turns import continue_turns
from dshell.solve.linear_solver import LinearSolver, SingularMatrixError, best_linear_solver

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MovingBody:
    """A moving body: its energies, masses and loads.

    Parameters
    ----------
    masses : array of float
        Mass behind each degree of freedom, kg, in the shape of the position; 0 if there is none.
    held : array of int
        Degrees of freedom that do not move, by their places in the flattened position.
    energies : callable
        Energies at a time (s), always on the same elements.
    load : callable
        Force on each degree of freedom at a time, N, in the shape of the position.
    damping_rate : float
        c, drag per mass and velocity, 1/s.
    """

    masses: Array
    held: NDArray[np.int64]
    energies: Callable[[float], Sequence[Energy]]
    load: Callable[[float], Array]
    damping_rate: float = 0.0

    def assembly(self) -> Assembly:
        """Return the assembly of the body's energies."""
        return Assembly(self.masses.size, self.energies(0.0), self.held)


@dataclass(frozen=True)
class NewtonRule:
    """When a time step has converged, and when it is given up.

    Parameters
    ----------
    tolerance : float
        Norm of the residual that is small enough, N.
    max_iterations : int
        Newton iterations allowed in one time step.
    """

    tolerance: float
    max_iterations: int


@dataclass(frozen=True)
class Stepping:
    """Settings of the time steps and their Newton iterations.

    Parameters
    ----------
    time_step : float
        h, s.
    steps : int
        Number of time steps.
    tolerance, max_iterations
        See `NewtonRule`.
    """

    time_step: float
    steps: int
    tolerance: float
    max_iterations: int

    @property
    def rule(self) -> NewtonRule:
        """When one of the steps has converged."""
        return NewtonRule(self.tolerance, self.max_iterations)


@dataclass(frozen=True)
class AdaptiveStepping:
    """Time steps that find their own length.

    A step that does not converge is tried again at half its length; one that needs few iterations
    lets the next be longer.

    Parameters
    ----------
    first_step : float
        Length of the first, s.
    end : float
        Time at which the last one ends, s.
    rule : NewtonRule
        When a step has converged.
    """

    first_step: float
    end: float
    rule: NewtonRule

    EASY: ClassVar[int] = 5
    """Iterations up to which a step counts as easy."""
    GROWTH: ClassVar[float] = 1.5
    HALVINGS: ClassVar[int] = 10
    """Number of halvings of the first step after which the motion is given up."""


@dataclass(frozen=True, eq=False)
class Motion:
    """The body at one time, and the iterations of the step to it.

    Parameters
    ----------
    time : float
        s.
    position, velocity : arrays of float
        m and m/s, nodes in shape (n, 3) or all degrees of freedom in a row.
    iterations : int
        Newton iterations of the step that ended here, and of those tried in its place before.
    error : float
        Norm of its last residual, N.
    """

    time: float
    position: Array
    velocity: Array
    iterations: int = 0
    error: float = 0.0


class ConvergenceError(ComputationError):
    """Newton-Raphson did not solve a time step; `iterations` and `error` say what was tried."""

    def __init__(self, time: float, iterations: int, error: float, tolerance: float) -> None:
        super().__init__(
            f"Newton-Raphson did not converge at {time:.4g} s: error {error:.3g} N after "
            f"{iterations} iterations, expected at most {tolerance:.3g} N"
        )
        self.iterations = iterations
        self.error = error


def implicit_euler(body: MovingBody, start: Motion, stepping: Stepping) -> Iterator[Motion]:
    """Advance a body in time, step by step.

    Parameters
    ----------
    body : MovingBody
        What moves.
    start : Motion
        Where it starts; not yielded.
    stepping : Stepping
        Time step, number of steps, and when a step has converged.

    Yields
    ------
    Motion
        The converged state at the end of each time step.

    Raises
    ------
    ConvergenceError
        A step did not converge; the last state yielded is the last good one.
    """
    assembly, linear = body.assembly(), best_linear_solver()
    motion = start
    for step in range(1, stepping.steps + 1):
        check_time()
        time = start.time + step * stepping.time_step
        motion = _step(body, assembly, linear, motion, time, stepping.time_step, stepping.rule)
        yield motion


def adaptive_euler(body: MovingBody, start: Motion, stepping: AdaptiveStepping) -> Iterator[Motion]:
    """Advance a body in time by steps that find their own length.

    Parameters
    ----------
    body : MovingBody
        What moves.
    start : Motion
        Where it starts; not yielded.
    stepping : AdaptiveStepping
        The first step, and the end.

    Yields
    ------
    Motion
        The converged state at the end of each time step; the last one at the end.

    Raises
    ------
    ConvergenceError
        The shortest step did not converge; the last state yielded is the last good one.
    """
    assembly, linear = body.assembly(), best_linear_solver()
    motion, wish = start, stepping.first_step
    shortest = stepping.first_step / 2**stepping.HALVINGS
    tried = 0
    while motion.time < stepping.end:
        check_time()
        left = stepping.end - motion.time
        h = left if wish >= left else min(wish, left / 2)  # no tiny step is left for the end
        time = stepping.end if h == left else motion.time + h
        try:
            done = _step(body, assembly, linear, motion, time, h, stepping.rule)
        except ConvergenceError as stop:
            tried += stop.iterations
            if h / 2 < shortest:
                stop.iterations = tried
                raise
            wish = h / 2
            continue
        if done.iterations <= stepping.EASY:
            wish = max(wish, h * stepping.GROWTH)
        motion = replace(done, iterations=done.iterations + tried)
        tried = 0
        yield motion


def _step(
    body: MovingBody,
    assembly: Assembly,
    linear: LinearSolver,
    old: Motion,
    time: float,
    h: float,
    rule: NewtonRule,
) -> Motion:
    """Solve one time step of length h, from a guess of unchanged velocity."""
    free = assembly.free
    energies, load = body.energies(time), body.load(time)
    masses = body.masses
    inertia = masses.reshape(-1)[free] * (1 / h**2 + body.damping_rate / h)
    position = old.position.copy()
    coordinates = position.reshape(-1)
    coordinates[free] += h * old.velocity.reshape(-1)[free]
    earlier = deform(energies, old.position)
    for iterations in range(rule.max_iterations + 1):
        velocity: Array = np.divide(position - old.position, h)
        momentum = masses * ((velocity - old.velocity) / h + body.damping_rate * velocity)
        deformed = deform(energies, position)
        continued = continue_turns(earlier, deformed, coordinates)
        if continued is not None:
            coordinates[:] = continued
            deformed = deform(energies, position)
        earlier = deformed
        forces = momentum - load
        residual = (forces.reshape(-1) + gradient_of(deformed))[free]
        error = float(np.linalg.norm(residual))
        if error <= rule.tolerance:
            return Motion(time, position, velocity, iterations, error)
        if not np.isfinite(error) or iterations == rule.max_iterations:
            break
        jacobian = assembly.hessian(deformed, diagonal=inertia)
        coordinates[free] -= _solved(linear, jacobian, residual)
    raise ConvergenceError(time, iterations, error, rule.tolerance)


def _solved(linear: LinearSolver, matrix: csc_matrix, right_side: Array) -> Array:
    """Solve a symmetric system; NaN if the matrix is singular."""
    try:
        return linear.factor(matrix).solve(right_side)
    except SingularMatrixError:
        return np.full_like(right_side, np.nan)
