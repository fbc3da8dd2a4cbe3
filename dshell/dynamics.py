"""The motion of lumped masses under energies, a load and drag: implicit Euler with Newton-Raphson.

Positions x and velocities v at the end of a time step of length h solve

    m (v - v_old) / h + m c v + dE/dx(x, t) = f(t),    v = (x - x_old) / h,

by full Newton steps on the residual of the free nodes, to a tolerance on its Euclidean norm.
Nothing here knows what the energies are, nor why they change with time.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from bilayer.errors import ComputationError
from dshell.assembly import Assembly, Energy, coordinates_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MovingBody:
    """What moves, and under what.

    Parameters
    ----------
    masses : (n,) array of float
        Mass of each node, kg.
    held_nodes : array of int
        Nodes that do not move.
    energies : callable
        Energies at a time (s), always on the same elements.
    load : callable
        Force on each node at a time, N, shape (n, 3).
    damping_rate : float
        c, drag per mass and velocity, 1/s.
    """

    masses: Array
    held_nodes: NDArray[np.int64]
    energies: Callable[[float], Sequence[Energy]]
    load: Callable[[float], Array]
    damping_rate: float = 0.0

    def assembly(self) -> Assembly:
        """Return the assembly of the body's energies."""
        stencils = [term.dofs for term in self.energies(0.0)]
        held = coordinates_of(self.held_nodes).reshape(-1)
        return Assembly(3 * len(self.masses), stencils, held)


@dataclass(frozen=True)
class Stepping:
    """How time and the Newton iterations advance.

    Parameters
    ----------
    time_step : float
        h, s.
    steps : int
        Number of time steps.
    tolerance : float
        Norm of the residual below which a step has converged, N.
    max_iterations : int
        Newton iterations allowed in one time step.
    """

    time_step: float
    steps: int
    tolerance: float
    max_iterations: int


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the body is at one time, and what the step to it took.

    Parameters
    ----------
    time : float
        s.
    position, velocity : (n, 3) arrays of float
        m and m/s.
    iterations : int
        Newton iterations of the step that ended here.
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
    assembly = body.assembly()
    motion = start
    for step in range(1, stepping.steps + 1):
        time = start.time + step * stepping.time_step
        motion = _step(body, assembly, motion, time, stepping)
        yield motion


def _step(
    body: MovingBody, assembly: Assembly, old: Motion, time: float, stepping: Stepping
) -> Motion:
    """Solve one time step, from a guess of unchanged velocity."""
    h, free = stepping.time_step, assembly.free
    energies, load = body.energies(time), body.load(time)
    masses = body.masses[:, None]
    inertia = np.repeat(body.masses, 3)[free] * (1 / h**2 + body.damping_rate / h)
    position = old.position.copy()
    coordinates = position.reshape(-1)
    coordinates[free] += h * old.velocity.reshape(-1)[free]
    for iterations in range(stepping.max_iterations + 1):
        velocity: Array = np.divide(position - old.position, h)
        momentum = masses * ((velocity - old.velocity) / h + body.damping_rate * velocity)
        residual = (momentum + assembly.gradient(energies, position) - load).reshape(-1)[free]
        error = float(np.linalg.norm(residual))
        if error <= stepping.tolerance:
            return Motion(time, position, velocity, iterations, error)
        if not np.isfinite(error) or iterations == stepping.max_iterations:
            break
        jacobian = assembly.hessian(energies, position, diagonal=inertia)
        coordinates[free] -= _solved(jacobian, residual)
    raise ConvergenceError(time, iterations, error, stepping.tolerance)


def _solved(matrix: csc_matrix, right_side: Array) -> Array:
    """Solve a symmetric system; NaN where the matrix is singular."""
    try:
        factors = splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})
    except RuntimeError:  # SuperLU: the factor is exactly singular
        return np.full_like(right_side, np.nan)
    return factors.solve(right_side)
