"""What speaks against the shape of a milestone: it is not stable, or it passes through itself."""

import numpy as np
import xarray as xr
from numpy.typing import NDArray


def is_unstable(result: xr.Dataset) -> NDArray[np.bool_]:
    """Whether another shape near by has less energy, for each milestone.

    False where the method cannot tell.
    """
    return np.asarray(result["unstable_modes"].values > 0)


def touches_itself(result: xr.Dataset) -> NDArray[np.bool_]:
    """Whether parts of the body overlap, for each milestone: contact is found, not resisted.

    False where it is not known, as in files older than the measure.
    """
    if "self_contact_gap" not in result:
        return np.zeros(result["converged"].shape, dtype=bool)
    return np.asarray(result["self_contact_gap"].values == 0)


def caveats(result: xr.Dataset) -> list[str]:
    """Return a few words for each milestone of one result, empty where nothing is against it."""
    words = zip(
        np.where(is_unstable(result), "unstable", ""),
        np.where(touches_itself(result), "touches itself", ""),
        strict=True,
    )
    return [", ".join(filter(None, pair)) for pair in words]
