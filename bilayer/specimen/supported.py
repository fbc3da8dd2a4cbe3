"""Supports: parts of the sheet that are held, in place of the six coordinates that hold it else."""

from dataclasses import dataclass

from bilayer.errors import InputError
from bilayer.specimen.named import check_name
from bilayer.specimen.part import Part
from bilayer.validation import keep, one_of, shown

SUPPORT_KINDS = {"clamped": "xyz", "hinged": "xyz", "guided": "z"}
"""Kinds of support, and the coordinates that each holds unless told."""
KEEPS_SLOPE = ("clamped", "guided")


@dataclass(frozen=True)
class Support:
    """A part of the sheet that is held.

    Parameters
    ----------
    name : str
        Its table [supports.NAME].
    kind : {"clamped", "hinged", "guided"}
        "clamped": held where it is flat, and its slope is kept; "hinged": held, free to turn;
        "guided": held in its plane, in which it slides, and its slope is kept.
    part : Part
        What is held.
    axes : str
        The coordinates that are held, some of "xyz"; "" are those of the kind.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Support("rim", "clamped", bilayer.Part("rim")).kind
    'clamped'
    """

    name: str
    kind: str
    part: Part
    axes: str = ""

    def __post_init__(self) -> None:
        check_name("supports", self.name)
        keep(self, one_of, "kind", choices=SUPPORT_KINDS)
        axes = self.axes or SUPPORT_KINDS[self.kind]
        is_some = isinstance(axes, str) and set(axes) <= set("xyz")
        if not is_some or len(set(axes)) != len(axes):
            raise InputError(f"axes = {shown(axes)}: expected some of 'xyz', such as 'z'")
        if self.keeps_slope and "z" not in axes:
            raise InputError(f"axes = {axes!r}: expected 'z' among them, a slope is kept there")
        object.__setattr__(self, "axes", "".join(sorted(axes)))
        if self.keeps_slope and self.part.point is not None:
            raise InputError(f"kind = {self.kind!r}: a point has no slope, expected 'hinged'")

    @property
    def keeps_slope(self) -> bool:
        """Whether the sheet cannot turn there."""
        return self.kind in KEEPS_SLOPE

    @property
    def words(self) -> str:
        """It in a few words."""
        usual = self.axes == SUPPORT_KINDS[self.kind]
        held = "" if usual else f", held in {' and '.join(self.axes)}"
        return f"{self.name}: {self.part} {self.kind}{held}"
