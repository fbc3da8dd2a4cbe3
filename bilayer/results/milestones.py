"""The milestones of a result as a dimension, also those of `result.sel(prestretch=1.06)`."""

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
