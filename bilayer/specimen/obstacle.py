"""Rigid obstacles that the sheet cannot pass through: planes and spheres."""

import math
from dataclasses import dataclass
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.named import check_name
from bilayer.validation import finite, keep, listed, positive, shown

UP = (0.0, 0.0, 1.0)
MOST_OBSTACLES = 50

Place = tuple[float, float, float]


@dataclass(frozen=True)
class PlaneObstacle:
    """A half space, such as a table.

    Parameters
    ----------
    name : str
        Its table [obstacles.NAME].
    point : (float, float, float) or None
        On its plane, m, where the flat reference surface lies at z = 0. None: the flat sheet lies
        on it, which takes a normal that points up.
    normal : (float, float, float)
        Out of it, toward the sheet; made a unit vector. Left out: up.

    Examples
    --------
    >>> PlaneObstacle("table", (0, 0, -0.005)).words
    'table: plane through (0, 0, -5) mm, normal (0, 0, 1)'
    """

    name: str
    point: Place | None = None
    normal: Place = UP

    def __post_init__(self) -> None:
        check_name("obstacles", self.name)
        if self.point is not None:
            object.__setattr__(self, "point", _place("point", self.point))
        normal = _place("normal", self.normal)
        length = math.hypot(*normal)
        if length == 0:
            raise InputError(f"normal = {shown(self.normal)}: expected not all of them 0")
        x, y, z = (part / length for part in normal)
        object.__setattr__(self, "normal", (x, y, z))
        if self.point is None and not self.is_level:
            raise InputError("point: missing, expected a place on a plane that is not level")

    @property
    def is_level(self) -> bool:
        """Whether it is a table: what lies on it can slide and turn, but not fall."""
        return self.normal == UP

    @property
    def words(self) -> str:
        """It in a few words."""
        if self.point is None:
            return f"{self.name}: plane on which the flat sheet lies"
        point, normal = _text(self.point, 1e3), _text(self.normal)
        return f"{self.name}: plane through {point} mm, normal {normal}"


@dataclass(frozen=True)
class SphereObstacle:
    """A ball.

    Parameters
    ----------
    name : str
        Its table [obstacles.NAME].
    centre : (float, float, float)
        m, where the flat reference surface lies at z = 0.
    radius : float
        m.

    Examples
    --------
    >>> SphereObstacle("ball", (0, 0, -0.02), 0.01).words
    'ball: sphere of 10 mm about (0, 0, -20) mm'
    """

    name: str
    centre: Place
    radius: float

    def __post_init__(self) -> None:
        check_name("obstacles", self.name)
        object.__setattr__(self, "centre", _place("centre", self.centre))
        keep(self, positive, "radius", unit="m")

    @property
    def words(self) -> str:
        """It in a few words."""
        return f"{self.name}: sphere of {1e3 * self.radius:g} mm about {_text(self.centre, 1e3)} mm"


Obstacle = PlaneObstacle | SphereObstacle
OBSTACLES: dict[str, type[Obstacle]] = {"plane": PlaneObstacle, "sphere": SphereObstacle}
"""Obstacles by the `shape` that they have in a file."""


def _place(field: str, given: Any) -> Place:
    parts = [finite(field, part) for part in listed(field, given)]
    if len(parts) != 3:
        raise InputError(f"{field} = {shown(given)}: expected [x, y, z]")
    x, y, z = parts
    return x, y, z


def _text(place: Place, scale: float = 1.0) -> str:
    return "({:g}, {:g}, {:g})".format(*(scale * part for part in place))
