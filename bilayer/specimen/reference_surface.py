"""The surface whose place a result tells: one of a layer's own, named in the file."""

import re
from dataclasses import dataclass

from bilayer.errors import InputError
from bilayer.validation import finite, keep

_NAMED = {0.0: "bottom", 0.5: "middle", 1.0: "top"}


@dataclass(frozen=True)
class ReferenceSurface:
    """A surface within a layer or at one of its sides.

    Parameters
    ----------
    layer : str
        Name of the layer.
    share : float
        Of the layer's thickness below it: 0 the layer's bottom, 0.5 its middle, 1 its top.
    """

    layer: str
    share: float

    def __post_init__(self) -> None:
        keep(self, finite, "share")
        if not 0 <= self.share <= 1:
            raise InputError(f"share = {self.share}: expected from 0 to 1")

    def __str__(self) -> str:
        """Return the text that a file keeps: "top of substrate"."""
        return f"{_NAMED.get(self.share, repr(self.share))} of {self.layer}"

    @classmethod
    def parse(cls, text: str) -> "ReferenceSurface":
        """Return the surface that a file's text names."""
        match = re.fullmatch(r"(top|middle|bottom|0?\.\d+) of (\S+)", text)
        if match is None:
            raise InputError(f"reference_surface = {text!r}: expected such as 'top of substrate'")
        where = {name: share for share, name in _NAMED.items()}
        return cls(match[2], where[match[1]] if match[1] in where else float(match[1]))
