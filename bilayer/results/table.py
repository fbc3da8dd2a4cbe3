"""Numbers of a result as the cells of a table."""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray


def stretches(result: xr.Dataset) -> NDArray[np.float64]:
    """Return (lambda_x, lambda_y) of each milestone, shape (milestones, 2)."""
    return np.column_stack([result["prestretch_x"].values, result["prestretch_y"].values])


def stretch_text(pair: NDArray[np.float64] | tuple[float, float]) -> str:
    """Return a prestretch as it is given on the command line: "1.06", or "1.06,1.05"."""
    return f"{pair[0]:g}" if pair[0] == pair[1] else f"{pair[0]:g},{pair[1]:g}"


def cells(values: ArrayLike, pattern: str) -> list[str]:
    """Return each number in a format such as "{:.2f}", and "-" for NaN."""
    return [pattern.format(v) if np.isfinite(v) else "-" for v in np.asarray(values)]
