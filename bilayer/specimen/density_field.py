"""A field of density: the share of a layer that lies at each place, for patterns nobody draws.

The shares belong to the nodes of a grid over the sheet, and between them they go linearly, which
filters out all that is finer than the grid (Bourdin, Int. J. Numer. Meth. Eng. 50, 2143, 2001). A
projection then drives them to 0 and 1 (Wang, Lazarov and Sigmund, Struct. Multidisc. Optim. 43,
767, 2011, with the threshold 1/2):

    share = (tanh(b / 2) + tanh(b (v - 1/2))) / (2 tanh(b / 2))

with the sharpness b and what the grid has, v. What is cut out is where the share is below a half.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.outline import Outline, Symmetry
from bilayer.specimen.pattern import Contours, Pattern
from bilayer.validation import finite, keep, listed, not_negative, one_of, positive, whole

Array = NDArray[np.float64]

MIRRORS = {"none": Symmetry(1, False), "axes": Symmetry(2, True), "diagonals": Symmetry(4, True)}
"""Lines about which the field is symmetric: none; both axes; both axes and their diagonals."""
LEAST_SHARPNESS = 1e-3
"""Below the projection is the identity."""
SLACK = 1e-3
"""By which a share may leave 0 and 1, for differences."""
MOST_COLUMNS = 1000


@dataclass(frozen=True)
class DensityField(Pattern):
    """The share of a layer at each place; the whole sheet counts as covered.

    Parameters
    ----------
    width, height : float
        Of the grid, whose centre is the origin, m; the sheet lies within.
    columns, rows : int
        Nodes of the grid along x and y, at least two each; with mirrors, of the quarter with
        x >= 0 and y >= 0 alone, its borders included.
    share : sequence of float
        At the nodes, from 0 to 1, row after row from the lowest. With the mirrors "diagonals" those
        up to the diagonal alone: one of the first row, two of the second, and so on.
    mirrors : {"none", "axes", "diagonals"}
        See `MIRRORS`.
    sharpness : float
        b; 0: the shares are those of the grid.

    Examples
    --------
    >>> import bilayer, numpy as np
    >>> field = bilayer.DensityField(0.04, 0.04, 2, 2, (0.0, 1.0, 0.0, 1.0))
    >>> field.share_at(np.array([[0.0, 0.01], [0.02, 0.0]])).tolist()
    [0.5, 1.0]
    >>> round(field.cut_pattern(bilayer.Rectangle(0.04, 0.04)).kept(bilayer.Disc(0.1)).area, 6)
    0.0008
    """

    width: float
    height: float
    columns: int
    rows: int
    share: tuple[float, ...]
    mirrors: str = "none"
    sharpness: float = 0.0

    def __post_init__(self) -> None:
        keep(self, positive, "width", "height", unit="m")
        keep(self, whole, "columns", "rows", at_least=2, at_most=MOST_COLUMNS)
        keep(self, one_of, "mirrors", choices=MIRRORS)
        keep(self, not_negative, "sharpness")
        shares = tuple(finite("share", value) for value in listed("share", self.share))
        if len(shares) != self._numbers.max() + 1:
            raise InputError(
                f"share: has {len(shares)} values, expected {self._numbers.max() + 1} for this grid"
            )
        if not -SLACK <= min(shares) <= max(shares) <= 1 + SLACK:
            raise InputError(f"share: has {min(shares):g} to {max(shares):g}, expected 0 to 1")
        object.__setattr__(self, "share", shares)

    @cached_property
    def _numbers(self) -> NDArray[np.int64]:
        """The number of the share at each node, (rows, columns)."""
        if self.mirrors != "diagonals":
            return np.arange(self.rows * self.columns).reshape(self.rows, self.columns)
        if (self.rows, self.height) != (self.columns, self.width):
            raise InputError(
                f"rows = {self.rows}, height = {self.height}: expected those of columns and width "
                "with the mirrors 'diagonals'"
            )
        row, column = np.indices((self.rows, self.columns))
        low, high = np.minimum(row, column), np.maximum(row, column)
        return high * (high + 1) // 2 + low

    def share_at(self, points: Array) -> Array:
        """Return the share at places of the sheet, (n,).

        Parameters
        ----------
        points : (n, 2) array of float
            m.
        """
        x, y = points.T
        reach = np.array([self.width, self.height])
        if self.mirrors == "none":
            at = np.column_stack([x, y]) / reach + 0.5
        else:
            at = np.abs(np.column_stack([x, y])) / (reach / 2)
        steps = np.array([self.columns, self.rows]) - 1
        at = np.clip(at, 0.0, 1.0) * steps
        cell = np.minimum(at.astype(np.int64), steps - 1)
        (u, v), (i, j) = (at - cell).T, cell.T
        values = np.array(self.share)[self._numbers]
        filtered = (
            (1 - u) * (1 - v) * values[j, i]
            + u * (1 - v) * values[j, i + 1]
            + (1 - u) * v * values[j + 1, i]
            + u * v * values[j + 1, i + 1]
        )
        return self._projected(filtered)

    def _projected(self, filtered: Array) -> Array:
        if self.sharpness < LEAST_SHARPNESS:
            return filtered
        end = math.tanh(self.sharpness / 2)
        return np.asarray((end + np.tanh(self.sharpness * (filtered - 0.5))) / (2 * end))

    def kept(self, outline: Outline) -> shapely.Geometry:
        """Return all of the outline: nothing is cut yet."""
        return outline.polygon

    def check_fit(self, outline: Outline) -> None:
        """Raise InputError unless the grid lies over all of the outline."""
        x0, y0, x1, y1 = outline.polygon.bounds
        for name, needed in (("width", 2 * max(-x0, x1)), ("height", 2 * max(-y0, y1))):
            if getattr(self, name) < (1 - SLACK) * needed:
                raise InputError(
                    f"{name} = {getattr(self, name):g} m: expected at least {needed:g} m, so that "
                    "the grid lies over all of the sheet"
                )

    def cut_pattern(self, outline: Outline, cells: int = 8, least_area: float = 0.0) -> Contours:
        """Return the pattern to cut: what is kept is where the share is a half or more.

        Parameters
        ----------
        outline : Outline
            The sheet's.
        cells : int
            Contours are found on a grid so many times finer.
        least_area : float
            Smaller parts and holes are dropped, m2.

        Raises
        ------
        InputError
            Nothing is kept, or nothing is cut.
        """
        from bilayer.drawings.packages import package  # contourpy is seldom needed

        contourpy = package("contourpy")
        twice = 1 if self.mirrors == "none" else 2
        x, y = (
            np.linspace(-size / 2, size / 2, twice * (count - 1) * cells + 1)
            for size, count in ((self.width, self.columns), (self.height, self.rows))
        )
        places = np.stack(np.meshgrid(x, y), axis=2)
        excess = self.share_at(places.reshape(-1, 2)).reshape(len(y), len(x)) - 0.5
        # a rim of nothing closes the contours beyond the grid's edges
        x, y = (np.concatenate([[2 * a[0] - a[1]], a, [2 * a[-1] - a[-2]]]) for a in (x, y))
        excess = np.pad(excess, 1, constant_values=-1.0)
        lines = contourpy.contour_generator(x, y, excess).lines(0.0)
        rings = [line[:-1] for line in lines if len(line) > 3]
        rings = [r for r in rings if shapely.Polygon(r).area > least_area]
        if not rings:
            raise InputError("share: is below a half everywhere, expected something to keep")
        pattern = Contours(tuple(tuple(map(tuple, r)) for r in rings))
        kept = pattern.kept(outline)
        return Pattern.from_geometry(kept)

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return MIRRORS[self.mirrors]

    @property
    def words(self) -> str:  # noqa: D102
        return f"a field of density of {self.columns} x {self.rows} nodes"
