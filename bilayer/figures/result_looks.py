"""One name, one colour and one marker for each solver and model, in every figure."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bilayer.figures.style import RESULT_COLOURS, RESULT_MARKERS, label_text

NAMES = {
    "fenics solid": "finite elements",
    "dshell morley": "shell (morley)",
    "dshell hinge": "shell (hinge)",
    "dshell paper": "shell (paper)",
    "calculix": "CalculiX",
}
"""By solver and model, in the order of the colours and markers."""
LINES = ("-", "--", ":", "-.")
"""Of the first, second, ... result of one solver and model."""


@dataclass(frozen=True)
class Look:
    """How a result is drawn.

    Parameters
    ----------
    name : str
        For legends and axes; nothing in it is read as mathematics.
    colour, marker, line : str
        As matplotlib has them.
    """

    name: str
    colour: str
    marker: str
    line: str = "-"

    @property
    def style(self) -> dict[str, Any]:
        """Arguments of `Axes.plot`; the rings of the reference show round what lies upon it."""
        look = {"color": self.colour, "marker": self.marker, "linestyle": self.line}
        ring = {"markersize": 7, "markerfacecolor": "none"} if self.marker == "o" else {}
        return look | ring


def result_looks(labels: Sequence[str]) -> list[Look]:
    """Return the look of each of some results that are drawn together.

    Parameters
    ----------
    labels : sequence of str
        See `bilayer.results.comparison.result_label`; a file's name in brackets may follow.

    Examples
    --------
    >>> [(look.name, look.line) for look in result_looks(["dshell morley", "fenics solid"])]
    [('shell (morley)', '-'), ('finite elements', '-')]
    """
    seen: Counter[str] = Counter()
    strangers = list(dict.fromkeys(label for label in labels if _known(label) is None))
    looks = []
    for label in labels:
        known = _known(label)
        place = list(NAMES).index(known) if known else len(NAMES) + strangers.index(label)
        kind = known or label
        looks.append(
            Look(
                label_text(plain_name(label)),
                RESULT_COLOURS[place % len(RESULT_COLOURS)],
                RESULT_MARKERS[place % len(RESULT_MARKERS)],
                LINES[seen[kind] % len(LINES)],
            )
        )
        seen[kind] += 1
    return looks


def result_name(label: str) -> str:
    """Return the name of one result in a figure."""
    return label_text(plain_name(label))


def plain_name(label: str) -> str:
    """Return the name of one result where no mathematics is read, as in a page."""
    known = _known(label)
    return label if known is None else NAMES[known] + label.removeprefix(known)


def _known(label: str) -> str | None:
    """Return the solver and model that a label begins with, if they have a name."""
    return next((known for known in NAMES if f"{label} ".startswith(f"{known} ")), None)
