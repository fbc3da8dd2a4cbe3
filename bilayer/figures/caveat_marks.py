"""Rings around the points of a plot whose shapes have something against them."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

_LOOKS: dict[str, dict[str, Any]] = {
    "unstable": {"marker": "s", "markersize": 10},
    "touches itself": {"marker": "o", "markersize": 10},
}


def mark_caveats(
    axes: Axes, x: ArrayLike, y: ArrayLike, unstable: ArrayLike, touching: ArrayLike
) -> None:
    """Frame the unstable points of a line and ring those of shapes that touch themselves.

    Each kind gets one entry in the legend, however often this is called.

    Parameters
    ----------
    axes : Axes
        Where the points are drawn.
    x, y : array_like of float, shape (n,)
        The points.
    unstable, touching : array_like of bool, shape (n,)
        What is against each; see `bilayer.results.caveats`.
    """
    for (label, look), found in zip(_LOOKS.items(), (unstable, touching), strict=True):
        marked: NDArray[np.bool_] = np.asarray(found, dtype=bool)
        if marked.any():
            known = label in axes.get_legend_handles_labels()[1]
            axes.plot(
                np.asarray(x)[marked], np.asarray(y)[marked], linestyle="none", color="0.25",
                markerfacecolor="none", markeredgewidth=0.9, clip_on=False,
                label=None if known else label, **look,
            )  # fmt: skip
