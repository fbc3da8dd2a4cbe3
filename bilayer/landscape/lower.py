"""Lower states than those that a result has, looked for at each of its milestones."""

import math
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import ComputationError
from bilayer.landscape.catalogue import NOWHERE
from bilayer.landscape.search import states
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import LOWER_STATE, result_mesh, result_specimen
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen

STARTS = 20
"""Of the search at each milestone, unless told."""
DESCRIBED = {
    "units": "1",
    "long_name": "energy, by the shell, of the lowest state that is known over that of this one, "
    "less 1; 0 none is lower",
}


def look_below(
    result: xr.Dataset,
    settings: Any = None,
    *,
    starts: int = STARTS,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return a result with `lower_state`: how far a lower state lies below each of its shapes.

    The shell looks for stable shapes at each milestone. The shape of the result, from whatever
    solver, is the first start; the state that it leads to is the one that the others are compared
    with.

    Parameters
    ----------
    result : Dataset
        From `bilayer.solve`.
    settings : MorleySettings or HingeSettings, optional
        Of the shell; the defaults of `morley` if left out.
    starts : int
        Of the search at each milestone.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        The same with the variable `lower_state`: -0.025 if a state is known whose energy is 2.5 %
        less, 0 if none is lower, NaN if the milestone has no shape or it leads to no state.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.016))  # coarse: for the example
    >>> result = bilayer.look_below(bilayer.solve(specimen, "dshell"), starts=2)
    >>> result["lower_state"].values.tolist()
    [0.0]
    """
    whole = along_milestones(result)
    count = whole.sizes["prestretch"]
    lower = []
    for row in range(count):
        if progress is not None:
            progress(row / count, f"lower states, milestone {row + 1} of {count}")
        lower.append(_lower_state(whole.isel(prestretch=[row]), row, settings, starts))
    return whole.assign({LOWER_STATE: ("prestretch", np.array(lower), DESCRIBED)})


def _lower_state(shape: xr.Dataset, row: int, settings: Any, starts: int) -> float:
    """Return the energy of the lowest state over that of a shape's own, less 1."""
    found = states_beside(shape, row, settings, starts)
    if found is None:
        return math.nan
    energy = found["energy"].sum("term").values
    return float(energy[0] / energy[own_state(found)] - 1)


def states_beside(shape: xr.Dataset, row: int, settings: Any, starts: int) -> xr.Dataset | None:
    """Return the states that a search finds from a shape and other starts.

    Parameters
    ----------
    shape : Dataset
        One milestone of a result; the first start.
    row : int
        Which milestone of its specimen that is.
    settings : MorleySettings, HingeSettings or None
        Of the shell.
    starts : int
        Of the search.

    Returns
    -------
    Dataset or None
        See `bilayer.landscape.search.states`; None if there is no shape, or it leads to no state.
    """
    if not bool(shape["converged"].values[0]):
        return None
    specimen = at_row(shape, row)
    try:
        found = states(specimen, settings, starts=starts, mesh=result_mesh(shape), start=shape)
    except ComputationError:
        return None
    return None if own_state(found) == NOWHERE else found


def own_state(found: xr.Dataset) -> int:
    """Return the number of the state that the first start, the shape itself, led to."""
    return int(found["start_state"].values[0])


def at_row(shape: xr.Dataset, row: int) -> Specimen:
    """Return the specimen of a result with one of its milestones alone."""
    specimen = result_specimen(shape)
    return specimen.with_milestones([specimen.prestretch.milestones[row]])
