"""Both solvers in one state: each is started from the other's shape if they are apart.

A thin sheet may have several stable shapes of nearly the same energy. Which one a solver comes to
is then chance, and the distance of two of them says nothing of the solvers.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import xarray as xr

from bilayer import ComputationError
from bilayer.results.comparison import compare

SolverName = Literal["fenics", "dshell"]
SolveFrom = Callable[[SolverName, xr.Dataset], xr.Dataset]
"""Computes a milestone by a solver, from the shape that the other one has there."""

SAME_STATE = 1e-4
"""Distance over the characteristic length of a state from itself, found in another way."""
STATES = {
    (True, True): "both",
    (True, False): "fenics",
    (False, True): "dshell",
    (False, False): "neither",
}
"""Who came to a state without the other's shape: by whether fenics and dshell did."""
UNKNOWN = "unknown"
"""State of solvers that are apart and were not started from each other's shapes."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A state by both solvers at one milestone.

    Parameters
    ----------
    state : str
        Who came to it without the other's shape, see `STATES`, or `UNKNOWN`.
    solid, shell : Dataset
        The finite-element model and the shell there, of one milestone.
    excess_solid, excess_shell : float
        Energy of the other state of each over that of this one, less 1; NaN: it has no other one.
    """

    state: str
    solid: xr.Dataset
    shell: xr.Dataset
    excess_solid: float = np.nan
    excess_shell: float = np.nan

    @property
    def distance(self) -> float:
        """Return the rms distance of the reference surfaces over the characteristic length."""
        return distance(self.solid, self.shell)


def distance(first: xr.Dataset, second: xr.Dataset) -> float:
    """Return the rms distance of two shapes over the characteristic length, NaN without one."""
    return float(compare(first, second)["rms_distance_over_radius"].item())


def energy(result: xr.Dataset) -> float:
    """Return the energy of a result of one milestone, J."""
    return float(result["energy"].sum("term", skipna=False).item())


def as_found(solid: xr.Dataset, shell: xr.Dataset, tolerance: float) -> Pair:
    """Return what both solvers came to by themselves; see `in_one_state`."""
    pair = Pair(STATES[True, True], solid, shell)
    return pair if pair.distance <= tolerance else replace(pair, state=UNKNOWN)


def in_one_state(
    solid: xr.Dataset, shell: xr.Dataset, tolerance: float, solve_from: SolveFrom
) -> Pair:
    """Return both solvers in one state at a milestone.

    If they are farther apart than a tolerance, each is started from the shape of the other. Then
    the finite-element model's state of lowest energy is taken, and the shell's nearest to it.

    Parameters
    ----------
    solid, shell : Dataset
        What the finite-element model and the shell came to by themselves, of one milestone.
    tolerance : float
        Over the characteristic length.
    solve_from : callable
        Starts a solver from a shape.
    """
    own = as_found(solid, shell, tolerance)
    if own.state != UNKNOWN:
        return own
    solids = _different([solid, *_reached(solve_from, "fenics", shell)])
    shells = _different([shell, *_reached(solve_from, "dshell", solid)])
    lowest = min(solids, key=energy)
    nearest = min(shells, key=lambda state: distance(lowest, state))
    return Pair(
        STATES[lowest is solid, nearest is shell],
        lowest,
        nearest,
        _excess(solids, lowest),
        _excess(shells, nearest),
    )


def _reached(solve_from: SolveFrom, solver: SolverName, start: xr.Dataset) -> list[xr.Dataset]:
    """Return what a solver comes to from a shape, nothing if it fails."""
    try:
        result = solve_from(solver, start)
    except ComputationError:
        return []
    return [result] if result["converged"].item() else []


def _different(states: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return a solver's own state, and the one it was led to if that is another one."""
    own, *led = states
    return [own, *(state for state in led if distance(own, state) > SAME_STATE)]


def _excess(states: Sequence[xr.Dataset], chosen: xr.Dataset) -> float:
    """Return the energy of the other state over that of the chosen one, less 1."""
    others = [energy(state) / energy(chosen) - 1 for state in states if state is not chosen]
    return min(others, default=np.nan)
