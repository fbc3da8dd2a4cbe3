"""The states of a search, confirmed by another solver that starts from each of them."""

import math
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import ComputationError
from bilayer.landscape.symmetry import Images, symmetry_of
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import solve

SAME_STATE = 0.05
"""Rms distance over the characteristic length within which two solvers have the same state.

Shell and finite-element model are 0.01 apart, states 0.04 and more; a larger one is another."""

VARIABLES = {
    "confirmed": ("1", "whether the other solver has a stable state there"),
    "confirmed_energy": ("J", "energy by the other solver"),
    "confirmed_distance": ("1", "rms distance over the flat sheet's radius"),
    "confirmed_modes": ("1", "number of unstable modes by the other solver, -1 unknown"),
}


def confirm(
    states: xr.Dataset,
    solver: str = "fenics",
    settings: Any = None,
    *,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the states of a search with what another solver comes to from each.

    Parameters
    ----------
    states : Dataset
        From `bilayer.states`.
    solver : str
        The solver.
    settings : settings dataclass, optional
        Of it; its defaults if left out.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        The same with the variables of `VARIABLES`. A state is confirmed if the solver converges to
        a stable equilibrium near it.
    """
    count = states.sizes["prestretch"]
    rows = []
    for k in range(count):
        if progress is not None:
            progress(k / count, f"state {k}")
        rows.append(_confirm_one(states.isel(prestretch=[k]), solver, settings))
    columns = dict(zip(VARIABLES, zip(*rows, strict=True), strict=True))
    described = {
        name: (
            "prestretch",
            np.array(column),
            dict(zip(("units", "long_name"), VARIABLES[name], strict=True)),
        )
        for name, column in columns.items()
    }
    return states.assign(described).assign_attrs(confirmed_by=solver)


def _confirm_one(state: xr.Dataset, solver: str, settings: Any) -> tuple[int, float, float, int]:
    specimen, mesh = result_specimen(state), result_mesh(state)
    specimen = specimen.with_milestones(specimen.prestretch.milestones[:1])  # all are the same
    try:
        other = solve(specimen, solver, settings, mesh=mesh, start=state)
    except ComputationError:
        return 0, math.nan, math.nan, -1
    if not other["converged"].all():
        return 0, math.nan, math.nan, -1
    images = Images(mesh, symmetry_of(specimen, specimen.prestretch.milestones[-1]))
    apart = images.distance(state["position"].values[0], other["position"].values[0])
    relative = apart / specimen.characteristic_length
    modes = int(other["unstable_modes"].values[0])
    energy = float(other["energy"].sum("term").values[0])
    return int(modes == 0 and relative < SAME_STATE), energy, relative, modes
