"""The equilibria between the milestones of a result, computed on its own mesh by its own solver."""

from itertools import pairwise

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.results.starting import FLAT_START
from bilayer.results.table import stretches
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import solve
from bilayer.solvers.rerun import result_settings
from bilayer.specimen.settings import check_plain

WITHOUT_START = "paper"
"""The model that takes no start."""


def solve_between(
    result: xr.Dataset, count: int, progress: Progress | bool | None = None, *, trust: bool = False
) -> xr.Dataset:
    """Compute a result again with further milestones between its own, evenly spaced.

    The shapes of the result are the initial guesses, so that the path is on its branches.

    Parameters
    ----------
    result : Dataset
        From `bilayer.solve` or `bilayer.open_result`; milestones that were not reached are left
        out.
    count : int
        Equilibria between any two milestones that follow one another.
    progress : callable or bool, optional
        See `bilayer.solve`.
    trust : bool
        Allow settings that could run code or write files. They come from the result's file.

    Returns
    -------
    Dataset
        See `bilayer.results.schema`.

    Raises
    ------
    InputError
        No solver of ours made the result, its settings are not plain, or `count` is less than 0.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.02, 1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> bilayer.solve_between(result, 1)["prestretch"].values.round(3)
    array([1.02 , 1.025, 1.03 ])
    """
    if count < 0:
        raise InputError(f"between = {count}: expected a whole number of at least 0")
    result = along_milestones(result)
    result = result.isel(prestretch=result["converged"].values == 1)
    settings = result_settings(result)
    if not trust:
        check_plain(settings)
    own = stretches(result)
    path = [
        first + share * (second - first)
        for first, second in pairwise(own)
        for share in np.linspace(0.0, 1.0, count + 1, endpoint=False)
    ]
    dense = [(float(x), float(y)) for x, y in [*path, *own[-1:]]]
    return solve(
        result_specimen(result).with_milestones(dense),
        result.attrs["solver"],
        settings,
        mesh=result_mesh(result),
        start=FLAT_START if result.attrs["model"] == WITHOUT_START else result,
        progress=progress,
    )
