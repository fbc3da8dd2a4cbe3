"""How a cut file says what is cut: names and colours of its lines, as cutting services ask."""

from dataclasses import dataclass

HAIRLINE = 1e-5
"""Width of the lines, m: programs of laser cutters take lines this thin as cuts."""


@dataclass(frozen=True)
class Style:
    """Layer names and colours.

    Parameters
    ----------
    cut, marks : str
        Names of the layers of cuts and of registration marks.
    cut_colour, marks_colour : str
        As "#rrggbb".
    """

    cut: str = "cut"
    marks: str = "marks"
    cut_colour: str = "#ff0000"
    marks_colour: str = "#0000ff"


STYLES = {
    "plain": Style(),
    "lightburn": Style(cut="C00", marks="T1", cut_colour="#000000", marks_colour="#f36926"),
    "ponoko": Style(cut_colour="#0000ff", marks_colour="#ff0000"),
    "trotec": Style(cut_colour="#ff0000", marks_colour="#000000"),
}
"""By the name of a service or a program: red for cuts, or what it asks for."""
