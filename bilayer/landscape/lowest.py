"""A result of the shell with the lowest state that a search finds at each milestone."""

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.landscape.lower import DESCRIBED, STARTS, at_row, own_state, states_beside
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import LOWER_STATE, result_mesh
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import solve
from bilayer.solvers.rerun import result_settings

BRANCH, PATH = "branch", "path"
"""Attribute: at which milestones the shape is one of the search; all are of the load path."""


def take_lowest(
    result: xr.Dataset, *, starts: int = STARTS, progress: Progress | None = None
) -> xr.Dataset:
    """Return a result with the lowest state that is found at each milestone.

    `bilayer.solve` returns the shapes that the load path comes to. This looks for other stable
    shapes at each milestone, with the result's own settings, and takes the lowest.

    Parameters
    ----------
    result : Dataset
        From `bilayer.solve` by the shell.
    starts : int
        Of the search at each milestone; the result's own shape is the first.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        The same, other states in place of those that were not the lowest. `lower_state` is 0, or
        NaN if the milestone has no shape or no start led to one. The attribute `branch` says at
        which milestones the shape is not that of the load path.

    Raises
    ------
    InputError
        The result is of another solver.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.016))  # coarse: for the example
    >>> bilayer.take_lowest(bilayer.solve(specimen, "dshell"), starts=2).attrs["branch"]
    'path'
    """
    if result.attrs["solver"] != "dshell":
        raise InputError(
            f"solver = {result.attrs['solver']!r}: expected a result of dshell; start the other "
            "solver from its shapes"
        )
    whole = along_milestones(result)
    count = whole.sizes["prestretch"]
    rows, known, others = [], [], []
    for place in range(count):
        if progress is not None:
            progress(place / count, f"lowest state, milestone {place + 1} of {count}")
        row = whole.isel(prestretch=[place])
        lowest = _lowest(row, place, starts)
        known.append(np.nan if lowest is None else 0.0)
        rows.append(row if lowest is None else lowest)
        if lowest is not None and lowest is not row:
            others.append(f"{row['prestretch'].values[0]:g}")
    branch = f"lowest of a search at {', '.join(others)}" if others else PATH
    joined = _joined(whole, rows).assign_attrs({BRANCH: branch})
    return joined.assign({LOWER_STATE: ("prestretch", np.array(known), DESCRIBED)})


def _lowest(row: xr.Dataset, place: int, starts: int) -> xr.Dataset | None:
    """Return a milestone in its lowest state: itself, another, or None if none was found."""
    settings = result_settings(row)
    found = states_beside(row, place, settings, starts)
    if found is None:
        return None
    if (
        own_state(found) == 0
    ):  # the lowest; an image of it may lie a little lower, as meshes are not symmetric
        return row
    start, mesh = found.isel(prestretch=[0]), result_mesh(row)
    lower = solve(at_row(row, place), "dshell", settings, mesh=mesh, start=start)
    return lower if bool(lower["converged"].all()) else None


def _joined(whole: xr.Dataset, rows: list[xr.Dataset]) -> xr.Dataset:
    """Return a result with its milestones replaced by those of other results."""
    names = [name for name, values in whole.data_vars.items() if "prestretch" in values.dims]
    everywhere = [name for name in names if all(name in row for row in rows)]
    parts = {name: [row.variables[name] for row in rows] for name in everywhere}
    changed = {name: xr.Variable.concat(parts[name], "prestretch") for name in everywhere}
    return whole.drop_vars(names).assign(changed)
