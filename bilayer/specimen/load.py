"""Loads on the sheet, each with a value at every milestone of the path."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.named import check_name
from bilayer.specimen.part import Part
from bilayer.validation import finite, listed, one_of, shown

LOAD_KINDS = {
    "pressure": "Pa",
    "force": "N",
    "line_force": "N/m",
    "body_force": "N/m^3",
    "displacement": "m",
}
"""Kinds of load, each the key of its values in a file, with their unit."""
RESPONSES = {
    "pressure": ("m3", "volume that it has swept"),
    "force": ("m", "displacement along it, mean over its part"),
    "line_force": ("m2", "displacement along it, times the length"),
    "body_force": ("m4", "displacement along it, times the volume"),
    "displacement": ("N", "force along it that it takes"),
}
"""What a load does its work on, by kind, with the unit: the work is that of load d(response).

That of a displacement is the force."""
FREE = "free"
"""The value of a displacement at a milestone where nothing is held."""
NOT_HELD = math.nan
MOST_LOADS = 50

WHOLE_SHEET = Part()

Milestone = tuple[float, ...]
"""(lambda_x, lambda_y), then the value of each load in its SI unit; NaN: a displacement is free."""


@dataclass(frozen=True)
class Load:
    """A load.

    Parameters
    ----------
    name : str
        Its table [loads.NAME].
    kind : str
        One of `LOAD_KINDS`. A pressure follows the surface and pushes from below; the other forces
        keep their direction. A displacement is imposed on its part, from the flat sheet.
    values : sequence of float or "free"
        At each milestone, in the unit of its kind; a single one holds at all of them.
    part : Part
        Where it acts.
    direction : (float, float, float)
        Of the force or displacement, made a unit vector; a pressure has none.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Load("blow", "pressure", [0.0, 50.0]).values
    (0.0, 50.0)
    """

    name: str
    kind: str
    values: tuple[float | str, ...]
    part: Part = WHOLE_SHEET
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        check_name("loads", self.name)
        one_of("kind", self.kind, LOAD_KINDS)
        values = tuple(self._checked(value) for value in _values(self.kind, self.values))
        object.__setattr__(self, "values", values)
        object.__setattr__(self, "direction", _unit_vector(self.direction))
        self._check_part()

    def _checked(self, value: Any) -> float | str:
        if value == FREE and self.kind == "displacement":
            return FREE
        return finite(self.kind, value)

    def _check_part(self) -> None:
        is_line = bool(self.part.line) or self.part.on != "sheet"
        if self.kind == "line_force" and not is_line:
            raise InputError(f"where = {self.part}: a line force expects the rim, holes or a line")
        if self.kind in ("pressure", "body_force") and (is_line or self.part.point is not None):
            raise InputError(f"where = {self.part}: a {self.kind} expects a region of the sheet")

    @property
    def unit(self) -> str:
        """Of its values."""
        return LOAD_KINDS[self.kind]

    @property
    def largest(self) -> float:
        """Largest absolute value; 0 of a displacement that is nowhere held."""
        return max((abs(v) for v in self.values if not isinstance(v, str)), default=0.0)

    @property
    def scale(self) -> float:
        """Largest absolute value; 1 if all are 0."""
        return self.largest or 1.0

    def at(self, milestone: int) -> float:
        """Return its value at a milestone, NaN if it is free there."""
        value = self.values[milestone if len(self.values) > 1 else 0]
        return NOT_HELD if isinstance(value, str) else value

    @property
    def words(self) -> str:
        """It in a few words."""
        kind = self.kind.replace("_", " ")
        along = "" if self.kind == "pressure" else " along ({:g}, {:g}, {:g})"
        return f"{self.name}: {kind} on {self.part}{along.format(*self.direction)}"


def _values(kind: str, given: Any) -> list[Any]:
    values = [given] if isinstance(given, (str, int, float)) else listed(kind, given)
    if not values:
        raise InputError(f"{kind} = []: expected at least one value")
    return values


def _unit_vector(given: Any) -> tuple[float, float, float]:
    parts: Sequence[float] = [finite("direction", part) for part in listed("direction", given)]
    length = math.hypot(*parts)
    if len(parts) != 3 or length == 0:
        raise InputError(f"direction = {shown(given)}: expected [x, y, z], not all of them 0")
    x, y, z = (part / length for part in parts)
    return x, y, z
