"""A part of the flat sheet that is held or loaded: the rim, the edges of holes, a region, a point.

A part is chosen among the nodes of the planar mesh, see `bilayer.mesh.parts`.
"""

from dataclasses import dataclass
from typing import Any

import shapely

from bilayer.errors import InputError
from bilayer.validation import finite, keep, listed, one_of, shown

Place = tuple[float, float]

BORDERS = ("sheet", "rim", "holes")
"""What the limits of a part choose from: the whole sheet, its outer edge, the edges of holes."""
MEASURED = ("x", "y", "r")
"""What a limit bounds: a coordinate, or the distance from the origin."""
RELATIONS = ("<=", ">=")


@dataclass(frozen=True)
class Limit:
    """A bound of a part.

    Parameters
    ----------
    measured : {"x", "y", "r"}
        The coordinate, or the distance from the origin.
    relation : {"<=", ">="}
        On which side of the bound the part lies.
    bound : float
        m.

    Examples
    --------
    >>> import bilayer
    >>> str(bilayer.Part("sheet", (bilayer.Limit("r", ">=", 0.03),)))
    'the sheet, r >= 30 mm'
    """

    measured: str
    relation: str
    bound: float

    def __post_init__(self) -> None:
        keep(self, one_of, "measured", choices=MEASURED)
        keep(self, one_of, "relation", choices=RELATIONS)
        keep(self, finite, "bound")

    def __str__(self) -> str:
        return f"{self.measured} {self.relation} {1e3 * self.bound:g} mm"


@dataclass(frozen=True)
class Part:
    """A part of the sheet.

    Parameters
    ----------
    on : {"sheet", "rim", "holes"}
        What it is a part of.
    limits : sequence of Limit
        All of them hold in it.
    point : (float, float), optional
        It is the one node nearest to here, m.
    line : sequence of (float, float), optional
        It is this line, along which the planar mesh gets edges, m. The line runs from edge to edge
        of the sheet, or is closed.

    Examples
    --------
    >>> str(Part("rim", (Limit("x", "<=", -0.019),)))
    'the rim, x <= -19 mm'
    """

    on: str = "sheet"
    limits: tuple[Limit, ...] = ()
    point: Place | None = None
    line: tuple[Place, ...] = ()

    def __post_init__(self) -> None:
        keep(self, one_of, "on", choices=BORDERS)
        object.__setattr__(self, "limits", tuple(self.limits))
        if self.point is not None:
            object.__setattr__(self, "point", _place("point", self.point))
        object.__setattr__(self, "line", tuple(_place("line", place) for place in self.line))
        if self.line and len(set(self.line)) == 1:
            raise InputError(f"line = {shown(self.line)}: expected at least two different points")
        if self.on != "sheet" and (self.line or self.point is not None):
            raise InputError(f"on = {self.on!r}: not together with a point or a line")
        if self.point is not None and (self.line or self.limits):
            raise InputError(f"point = {shown(self.point)}: expected alone")

    @property
    def drawn(self) -> shapely.LineString | None:
        """The line along which the planar mesh gets edges, if there is one."""
        return shapely.LineString(self.line) if self.line else None

    def __str__(self) -> str:
        if self.point is not None:
            return "the point ({:g}, {:g}) mm".format(*(1e3 * x for x in self.point))
        first = "a line" if self.line else {"holes": "the edges of holes"}.get(self.on)
        return ", ".join([first or f"the {self.on}", *map(str, self.limits)])


def _place(field: str, given: Any) -> Place:
    pair = listed(field, given)
    if len(pair) != 2:
        raise InputError(f"{field} = {shown(given)}: expected [x, y]")
    return finite(field, pair[0]), finite(field, pair[1])
