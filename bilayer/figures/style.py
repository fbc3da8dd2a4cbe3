"""The style of the figures: fonts and lines for print, colours for colour-blind readers.

What the user has set in matplotlib's own settings (`rcParams`, a style sheet) stays.
"""

import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from bilayer.runtime.terminal import one_line

KIRIGAMI_COLOUR, BARE_COLOUR = "#4477AA", "#EEBB44"
FURTHER_COLOURS = ("#228833", "#AA3377", "#66CCEE", "#CCBB44", "#BBBBBB")
"""Of regions: all layers, one layer, any between (Paul Tol's bright scheme)."""
RESULT_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#000000")
RESULT_MARKERS = ("o", "s", "^", "D", "v", "P")
"""One per result, in their order (colours: Okabe and Ito 2008, Color universal design)."""

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.labelsize": 9,
    "axes.titlesize": 9,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.linewidth": 0.7,
    "lines.linewidth": 1.3,
    "lines.markersize": 5,
    "axes.grid": False,
    "grid.color": "0.85",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "pdf.fonttype": 42,  # TrueType: journals refuse Type 3
    "ps.fonttype": 42,
    "svg.hashsalt": "bilayer",  # the same names of parts in every file
}


SCREEN_DOTS_PER_INCH = 100
LONGEST_LABEL = 120
"""Letters of a name that are drawn."""


def label_text(name: object) -> str:
    r"""Return a name from a file as a label: nothing in it is read as mathematics or as a command.

    matplotlib takes what stands between two dollar signs for mathematics, and leaves labels that
    begin with an underscore out of the legend.

    Examples
    --------
    >>> label_text("cost in $_a$")
    'cost in \$_a\$'
    """
    text = one_line(name)
    if len(text) > LONGEST_LABEL:
        text = f"{text[:LONGEST_LABEL]}..."
    text = text.replace("$", r"\$")
    return f"\N{ZERO WIDTH SPACE}{text}" if text.startswith("_") else text


@contextmanager
def print_style() -> Iterator[None]:
    """Draw inside with the settings for print; those that the user has changed stay."""
    with mpl.rc_context():
        untouched = {
            name: value
            for name, value in _STYLE.items()
            if mpl.rcParams[name] == mpl.rcParamsDefault[name]
        }
        mpl.rcParams.update(untouched)
        mpl.rcParams["text.usetex"] = False  # it would read names of files as commands
        yield


class ShownFigure(Figure):
    """A figure that a notebook shows, also where pyplot was not loaded."""

    def _repr_png_(self) -> bytes:
        """Return the figure as the bytes of a PNG."""
        picture = io.BytesIO()
        with print_style():
            FigureCanvasAgg(self).print_figure(picture, format="png", dpi=SCREEN_DOTS_PER_INCH)
        return picture.getvalue()


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure of a size in inches that arranges its own panels."""
    return ShownFigure(figsize=(width, height), layout="constrained")


def axes_for(ax: Axes | None, width: float, height: float) -> tuple[Figure, Axes]:
    """Return a figure and the axes to draw in: those of the user, or new ones of a size, inches."""
    if ax is None:
        figure = new_figure(width, height)
        return figure, figure.add_subplot()
    return ax.get_figure(), ax  # type: ignore[return-value]


def legend_for(figure: Figure, ax: Axes | None, axes: Axes, columns: int) -> None:
    """Put the legend above a figure of our own, or into the axes of the user."""
    if ax is None:
        figure.legend(loc="outside upper center", ncols=columns)
    else:
        axes.legend()
