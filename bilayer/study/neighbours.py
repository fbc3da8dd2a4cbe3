"""Cases that differ by little: one starts from the shapes of another, if that gives the same state.

A neighbour has the same planar mesh, solver, settings and milestones, and values that are not far.
Its shapes are initial guesses at all milestones, and Newton's method takes two iterations where it
takes nine from flat. A specimen may have several stable shapes. The usual way, from flat, decides
which of them is the result, so a part of the cases is computed in both ways: every one in doubt,
and a sample of the others. If their energies differ, the usual result is kept, the cases since the
last agreement are computed again, and no more neighbours are used on that mesh.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import xarray as xr

from bilayer.mesh.generation import generate_mesh
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.starting import Neighbour
from bilayer.solvers.registry import solver_named
from bilayer.specimen.settings import settings_to_toml
from bilayer.study.case import Case

CLOSE = 0.25
"""Largest relative difference of a value that varies."""
SAME_ENERGY = 1e-9
"""Relative difference of two energies of the same state."""
SAMPLE = 16
"""One case of so many is computed in both ways."""
FEW_ITERATIONS = 6
"""Newton iterations to a milestone; a case that takes more from a neighbour is in doubt."""
KEPT = 24
"""Results that are kept on one mesh, the last ones."""

Solve = Callable[..., xr.Dataset]
"""`bilayer.solve` of a case, which takes `mesh` and `start`."""


@dataclass
class _Group:
    """The cases on one mesh.

    Parameters
    ----------
    mesh : PlanarMesh
        Made once.
    done : list of (Case, Dataset)
        Whose shapes can start others.
    unchecked : list of Case
        Started by a neighbour since the last agreement.
    trusted : bool
        Whether neighbours gave the same states so far.
    """

    mesh: PlanarMesh
    done: list[tuple[Case, xr.Dataset]] = field(default_factory=list)
    unchecked: list[Case] = field(default_factory=list)
    trusted: bool = True


class Neighbours:
    """The results of one process that can start other cases.

    Parameters
    ----------
    sample : int
        One case of so many is computed in both ways.
    """

    def __init__(self, sample: int = SAMPLE) -> None:
        self._sample = sample
        self._groups: dict[tuple[Any, ...], _Group] = {}
        self._started = 0
        self._withdrawn: list[Case] = []

    def solve(self, case: Case, solve: Solve) -> xr.Dataset:
        """Return the result of a case, from a neighbour's shapes if that is as good.

        Parameters
        ----------
        case : Case
            What to compute.
        solve : callable
            Computes it, given the keywords `mesh` and perhaps `start`.
        """
        if not solver_named(case.solver).takes_neighbours(case.settings):
            return solve()
        group = self._group_of(case)
        near = _nearest(case, group.done) if group.trusted else None
        if near is None:
            result = solve(mesh=group.mesh)
        else:
            result = self._solve_near(case, near, group, solve)
        if _is_doubtless(result):
            group.done = [*group.done[1 - KEPT :], (case, result)]
        return result

    def withdrawn(self) -> list[Case]:
        """Return, once, the cases whose results may be of another state than the usual one."""
        cases, self._withdrawn = self._withdrawn, []
        return cases

    def _solve_near(self, case: Case, near: xr.Dataset, group: _Group, solve: Solve) -> xr.Dataset:
        result = solve(mesh=group.mesh, start=Neighbour(near))
        self._started += 1
        is_sample = self._started % self._sample == 1 or self._sample == 1
        if _is_doubtless(result) and _took_few_iterations(result) and not is_sample:
            group.unchecked.append(case)
            return result
        usual = solve(mesh=group.mesh)
        if not _same_states(result, usual):
            self._withdrawn += group.unchecked
            group.trusted, group.done = False, []
        group.unchecked = []
        return usual

    def _group_of(self, case: Case) -> _Group:
        milestones = case.specimen.prestretch.milestones
        settings = settings_to_toml(case.settings)
        key = (case.mesh_identity, case.solver, case.model, settings, milestones)
        if key not in self._groups:
            self._groups[key] = _Group(self._mesh_of(case))
        return self._groups[key]

    def _mesh_of(self, case: Case) -> PlanarMesh:
        for key, group in self._groups.items():
            if key[0] == case.mesh_identity:
                return group.mesh
        return generate_mesh(case.specimen)


class NoNeighbours:
    """Every case is computed in the usual way."""

    def solve(self, case: Case, solve: Solve) -> xr.Dataset:
        """See `Neighbours.solve`."""
        return solve()


def _nearest(case: Case, done: list[tuple[Case, xr.Dataset]]) -> xr.Dataset | None:
    """Return the result of the case with the nearest values, the last of those; None if far."""
    best, found = CLOSE, None
    for other, result in done:
        distance = _distance(case, other)
        if distance <= best:
            best, found = distance, result
    return found


def _distance(case: Case, other: Case) -> float:
    """Return the largest relative difference of two cases' values; infinite if not of numbers."""
    pairs = [(case.values[name], other.values.get(name)) for name in case.values]
    return max((_apart(one, two) for one, two in pairs), default=0.0)


def _apart(one: Any, two: Any) -> float:
    if one == two:
        return 0.0
    numbers = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in (one, two))
    return abs(one - two) / max(abs(one), abs(two)) if numbers else math.inf


def _is_doubtless(result: xr.Dataset) -> bool:
    """Whether every milestone was reached, in a state that is known to be stable."""
    return bool((result["converged"] == 1).all() and (result["unstable_modes"] == 0).all())


def _took_few_iterations(result: xr.Dataset) -> bool:
    return bool((result["iterations"] <= FEW_ITERATIONS).all())


def _same_states(one: xr.Dataset, other: xr.Dataset) -> bool:
    """Whether two results are equal: reached alike, with the same energies and stability."""
    alike = all(
        np.array_equal(one[name].values, other[name].values)
        for name in ("converged", "unstable_modes")
    )
    first, second = (result["energy"].sum("term").values for result in (one, other))
    same = np.allclose(first, second, rtol=SAME_ENERGY, atol=0.0, equal_nan=True)
    return alike and bool(same)
