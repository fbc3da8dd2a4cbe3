"""Lines that end where the shapes change to another branch: what lies between was not computed."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

JUMP = 4.0
"""Change per unit of the abscissa, over the larger one of its neighbours, that is another branch.

The square root by which a branch leaves another at a bifurcation has a first step 2.4 times as
large as its second one; such a line stays joined.
"""
SMALLEST = 0.1
"""Change of a measure, of the order of one, that is never another branch."""


def branch_changes(x: ArrayLike, measures: ArrayLike) -> NDArray[np.bool_]:
    """Return between which neighbouring points the shapes change to another branch.

    The rule is one of the eye: the measures jump, and do not to either side of it.

    Parameters
    ----------
    x : array_like of float, shape (n,)
        Where the points are, in the order of the line.
    measures : array_like of float, shape (n, k)
        Numbers of the order of one that describe the shape; not a number if there is none.

    Returns
    -------
    ndarray of bool, shape (n - 1,)

    Examples
    --------
    >>> branch_changes([1, 2, 3, 4], [[0.9], [0.8], [0.2], [0.1]]).tolist()
    [False, True, False]
    """
    along = np.asarray(x, dtype=float)
    values = np.asarray(measures, dtype=float).reshape(len(along), -1)
    if len(along) < 3:
        return np.zeros(max(len(along) - 1, 0), dtype=bool)
    steps = np.abs(np.diff(along))
    typical = np.median(steps[steps > 0]) if (steps > 0).any() else 1.0
    change = np.abs(np.diff(values, axis=0)).max(axis=1)
    rate = np.nan_to_num(change / np.where(steps > 0, steps, typical))
    padded = np.concatenate([[0.0], rate, [0.0]])
    beside = np.maximum(padded[:-2], padded[2:])
    return np.asarray((rate > JUMP * beside) & (change > SMALLEST))


def line_with_gaps(
    x: ArrayLike, y: ArrayLike, changes: NDArray[np.bool_]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a line with a gap, a point that is no number, wherever the branch changes."""
    places = np.flatnonzero(changes) + 1
    along, up = np.asarray(x, dtype=float), np.asarray(y, dtype=float)
    return np.insert(along, places, np.nan), np.insert(up, places, np.nan)
