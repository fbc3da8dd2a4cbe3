"""The barrier between two states by another solver, started from the shell's states and pass."""

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import ComputationError, InputError
from bilayer.landscape.barrier import MODES
from bilayer.landscape.confirm import SAME_STATE
from bilayer.landscape.symmetry import Images, symmetry_of
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import settings_class, solve

UP, BACK = "confirmed_barrier", "confirmed_barrier_back"
"""Attributes: energy from the first and from the second state up to the pass, J."""
CONFIRMED_MODES = "confirmed_saddle_modes"
"""Attribute: unstable modes of the other solver's saddle."""
BY = "confirmed_by"
"""Attribute: the other solver."""
PLACES = ("the first state", "the saddle", "the second state")


def confirm_barrier(
    way: xr.Dataset,
    solver: str = "fenics",
    settings: Any = None,
    *,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Return the way between two states with the barrier that another solver finds there.

    The solver starts from both states and from the saddle. There it takes the equilibrium that is
    near, and does not leave it for a stable one.

    Parameters
    ----------
    way : Dataset
        From `bilayer.barrier`, with a saddle.
    solver : str
        The solver.
    settings : settings dataclass, optional
        Of it; its defaults if left out.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        The same with the attributes `confirmed_barrier` and `confirmed_barrier_back` (J),
        `confirmed_saddle_modes` and `confirmed_by`. Unless these modes are as many as the
        `saddle_modes` of the way, the solver came to another equilibrium: not confirmed.

    Raises
    ------
    InputError
        The way has no saddle.
    ComputationError
        The solver finds no equilibrium near one of the three shapes.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.confirm_barrier(bilayer.solve(bilayer.paper_specimen(), "dshell"))
    Traceback (most recent call last):
    bilayer.errors.InputError: way: has no saddle, expected one from `bilayer.barrier`
    """
    if way.attrs.get(MODES, -1) < 0:
        raise InputError("way: has no saddle, expected one from `bilayer.barrier`")
    chosen = settings_class(solver)() if settings is None else settings
    saddle = int(np.flatnonzero(way["unstable_modes"].values >= 0)[0])
    rows = (0, saddle, way.sizes["prestretch"] - 1)
    staying = replace(chosen, branch="unstable")
    found = []
    for count, (row, how) in enumerate(zip(rows, (chosen, staying, chosen), strict=True)):
        if progress is not None:
            progress(count / len(rows), PLACES[count])
        found.append(_equilibrium_near(way.isel(prestretch=[row]), PLACES[count], solver, how))
    first, top, second = (float(each["energy"].sum("term").values[0]) for each in found)
    return way.assign_attrs(
        {
            UP: top - first,
            BACK: top - second,
            CONFIRMED_MODES: int(found[1]["unstable_modes"].values[0]),
            BY: solver,
        }
    )


def _equilibrium_near(shape: xr.Dataset, place: str, solver: str, settings: Any) -> xr.Dataset:
    """Return the result of another solver that starts from a shape of the way."""
    specimen, mesh = result_specimen(shape), result_mesh(shape)
    specimen = specimen.with_milestones(specimen.prestretch.milestones[:1])
    found = solve(specimen, solver, settings, mesh=mesh, start=shape)
    if not found["converged"].all():
        raise ComputationError(f"{place}: {solver} {found.attrs['stop_reason']}")
    images = Images(mesh, symmetry_of(specimen, specimen.prestretch.milestones[0]))
    apart = images.distance(shape["position"].values[0], found["position"].values[0])
    if apart > SAME_STATE * specimen.characteristic_length:
        away = apart / specimen.characteristic_length
        raise ComputationError(
            f"{place}: {solver} comes to another state, {away:.1%} of the radius away"
        )
    return found


def is_confirmed(way: xr.Dataset) -> bool:
    """Whether the other solver's equilibrium has as many unstable modes as the shell's saddle."""
    return bool(way.attrs[CONFIRMED_MODES] == way.attrs[MODES])


def describe_confirmed(way: xr.Dataset) -> str:
    """Return what the other solver has found, in a sentence or two."""
    up, back, modes = way.attrs[UP], way.attrs[BACK], way.attrs[CONFIRMED_MODES]
    found = (
        f"{way.attrs[BY]}: {1e6 * up:.4g} uJ up and {1e6 * back:.4g} uJ back, over an equilibrium "
        f"with {modes} unstable mode{'s' * (modes != 1)}"
    )
    if is_confirmed(way):
        return found
    return (
        f"{found}\nNOT CONFIRMED: the shell's saddle has {way.attrs[MODES]}, so it is another one"
    )
