"""The lines of a drawing: what the readers of DXF and SVG return."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
"""Shape (k, 2)."""
Curve = Callable[[NDArray[np.float64]], Points]
"""The points of a curve at some parameters."""


@dataclass(frozen=True)
class Line:
    """One line of a drawing, its curves flattened.

    Parameters
    ----------
    points : ndarray, shape (k, 2)
        In the drawing's unit and along its own axes.
    closed : bool
        Whether the last point is joined to the first, which is not repeated.
    layers : tuple of str
        Names by which the layer on which it lies is known; of SVG those of all groups around it,
        the outermost first, and its own.
    colour : str
        As "#rrggbb"; "" without one.
    hidden : bool
        Whether nobody sees it, as on a layer that is switched off or without stroke and fill.
    strange : str
        What it is if that is no line, such as "SOLID"; it has no points then.
    """

    points: Points
    closed: bool
    layers: tuple[str, ...]
    colour: str
    hidden: bool = False
    strange: str = ""


class Document(Protocol):
    """A drawing that has been opened."""

    unit: float | None
    """One unit of the drawing, m; None where the file does not say it."""
    how_to_tell: str
    """What is expected of the user where the file does not say the unit."""

    def lines(self, tolerance: float) -> list[Line]:
        """Return all lines, curves flattened to a tolerance in the drawing's unit."""

    def upright(self, points: Points) -> Points:
        """Return points along x to the right and y upwards, in the drawing's unit."""


def flattened(curve: Curve, breaks: Sequence[float], tolerance: float) -> Points:
    """Return a polyline along a curve that keeps its area and its moments.

    Points on the curve would make every polygon too small. Within a smooth piece they are moved
    outwards by a twelfth of their second difference, two thirds of the height of an arc over its
    chord, those beside an end by half as much again: the polyline then lies as much outside of the
    curve as inside, and the error of an area falls with the square of the tolerance.

    Parameters
    ----------
    curve : callable
        Its points, shape (k, 2), at parameters of shape (k,).
    breaks : sequence of float
        Parameters of the ends, and of all places where it may have a corner, ascending; these
        stay where they are.
    tolerance : float
        Largest distance from the curve, in its unit.

    Returns
    -------
    ndarray, shape (k, 2)
        Both ends among them.

    Examples
    --------
    >>> import numpy as np
    >>> half = flattened(lambda t: np.column_stack([np.cos(t), np.sin(t)]), [0, np.pi], 1e-4)
    >>> len(half)
    113
    """
    pieces = [np.asarray(curve(np.array([breaks[0]])))]
    for first, last in pairwise(breaks):
        rough = np.asarray(curve(_between(first, last, 32)))
        bend = np.linalg.norm(second_difference(rough), axis=1).max()
        count = max(1, int(np.ceil(32 * np.sqrt(bend / (8 * tolerance)) - 1e-9)))
        points = np.array(curve(_between(first, last, count)))
        if count > 1:
            moved = -second_difference(points) / 12
            moved[0] += moved[0] / 2  # for the half of the chord at an end that stays
            moved[-1] += moved[-1] / 2
            points[1:-1] += moved
        pieces.append(points[1:])
    return np.concatenate(pieces)


def second_difference(points: Points) -> Points:
    """Return the second differences of consecutive points, shape (k - 2, 2)."""
    return points[:-2] - 2 * points[1:-1] + points[2:]


def _between(first: float, last: float, count: int) -> NDArray[np.float64]:
    """Return the ends of `count` equal parts, shape (count + 1,)."""
    return first + (last - first) * np.arange(count + 1, dtype=np.float64) / count
