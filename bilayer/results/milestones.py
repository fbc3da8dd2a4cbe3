"""The milestones of a result as a dimension, also those of `result.sel(prestretch=1.06)`."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from bilayer.errors import InputError

FLAT_BODY = (
    "midsurface", "reference_x", "reference_y", "reference_position", "face_nodes", "region",
    "layers_present",
    "volume", "volume_reference_x", "volume_reference_y", "volume_reference_z",
    "volume_reference_position", "volume_cells", "layer",
)  # fmt: skip
"""Variables of the flat body, which all milestones share."""


def along_milestones(result: xr.Dataset) -> xr.Dataset:
    """Return a result with the dimension `prestretch`, of length one if it is a single milestone.

    Parameters
    ----------
    result : Dataset
        A result or a comparison, whole or chosen from by `sel` or `isel`.

    Raises
    ------
    InputError
        It is no dataset, or has no milestones.
    """
    if not isinstance(result, xr.Dataset):
        raise InputError(
            f"result = {type(result).__name__}: expected one dataset, as `solve` returns it"
        )
    if "prestretch" not in result.coords:
        raise InputError(
            "result: has no prestretch, expected a dataset as `solve` returns it, or some of its "
            "milestones"
        )
    if "prestretch" in result.dims:
        return result
    shared = [name for name in FLAT_BODY if name in result]
    of_milestones = result.drop_vars(shared).expand_dims("prestretch")
    scalars = {name: c for name, c in of_milestones.coords.items() if c.ndim == 0}
    spread = {name: ("prestretch", [c.values], c.attrs) for name, c in scalars.items()}
    return of_milestones.assign_coords(spread).assign(result[shared].data_vars)


def choose_milestones(result: xr.Dataset, stretches: Sequence[float]) -> xr.Dataset:
    """Return a result with some of its milestones, in their order in the result.

    Parameters
    ----------
    result : Dataset
        Along its milestones.
    stretches : sequence of float
        Their prestretches; a prestretch that the path took more than once gives all its visits.

    Raises
    ------
    InputError
        The result has no such milestone.
    """
    there = result["prestretch"].values
    chosen = np.zeros(len(there), dtype=bool)
    for stretch in stretches:
        found = np.isclose(there, stretch, rtol=0, atol=1e-9)
        if not found.any():
            listed = ", ".join(f"{one:g}" for one in there)
            raise InputError(
                f"prestretch = {stretch:g}: not in the result, expected one of {listed}"
            )
        chosen |= found
    return result.isel(prestretch=chosen)
