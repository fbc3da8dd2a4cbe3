"""The outline of a flat sheet: a disc, an ellipse, a rectangle, a regular or any other polygon.

An outline is a frozen dataclass. Each knows its area by a formula and its `polygon`, in which arcs
are many short lines (`SEGMENTS` a turn), for everything that shapely answers: what lies within,
where outline and pattern cross. Lengths that belong to a sheet as a whole, such as tolerances and
the size of an imperfection, are shares of its `characteristic_length`.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.validation import finite, keep, listed, not_negative, positive, whole, within

SEGMENTS = 720
"""Lines that stand for a full turn of an arc: 1e-5 of the radius from it."""
MOST_SIDES = 10_000
LARGEST_ANGLE = 1000.0
"""By which an outline may be turned, rad: a float of 1e30 has no digits left for part of a turn."""
LARGEST_RATIO = 1e6
"""Of the sides of a rectangle: beyond it, corners fall together within round-off."""

Ring = tuple[tuple[float, float], ...]


class Symmetry(NamedTuple):
    """The motions that leave a flat shape unchanged.

    Parameters
    ----------
    turns : int
        Turning it about the origin by 1/turns of a full turn; 0: by any angle, 1: by none.
    mirrored : bool
        Mirroring it at the x axis.
    """

    turns: int
    mirrored: bool

    def common(self, other: "Symmetry") -> "Symmetry":
        """Return the symmetry that both shapes have."""
        return Symmetry(math.gcd(self.turns, other.turns), self.mirrored and other.mirrored)


class Outline(Protocol):
    """A flat region of the plane, in one piece."""

    @property
    def polygon(self) -> shapely.Polygon:
        """The region, arcs as many short lines, m."""

    @property
    def area(self) -> float:
        """Area, m2."""
        return float(self.polygon.area)

    @property
    def centroid(self) -> tuple[float, float]:
        """Centre of its area, m."""
        return 0.0, 0.0

    @property
    def characteristic_length(self) -> float:
        """Radius of the circle of the same area, m."""
        return math.sqrt(self.area / math.pi)

    @property
    def symmetry(self) -> Symmetry:
        """The motions that leave it unchanged."""

    @property
    def words(self) -> str:
        """Description for a report, lengths in mm."""

    @property
    def identity(self) -> str:
        """A text that two outlines share if they are the same."""
        return repr(self)


@dataclass(frozen=True)
class Disc(Outline):
    """A circle around the origin.

    Parameters
    ----------
    radius : float
        m.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Disc(0.04).characteristic_length
    0.04
    """

    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", positive("outer_radius", self.radius, "m"))

    @cached_property
    def polygon(self) -> shapely.Polygon:  # noqa: D102
        return shapely.Polygon(arc(self.radius, 0.0, 2 * math.pi)[:-1])

    @property
    def area(self) -> float:  # noqa: D102
        return math.pi * self.radius**2

    @property
    def characteristic_length(self) -> float:
        """Its radius, m."""
        return self.radius

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return Symmetry(0, True)

    @property
    def words(self) -> str:  # noqa: D102
        return f"radius {1e3 * self.radius:g} mm"


@dataclass(frozen=True)
class Ellipse(Outline):
    """An ellipse around the origin, its axes along x and y.

    Parameters
    ----------
    width, height : float
        Whole axes along x and y, m.

    Examples
    --------
    >>> import bilayer
    >>> round(bilayer.Ellipse(0.08, 0.02).characteristic_length, 6)
    0.02
    """

    width: float
    height: float

    def __post_init__(self) -> None:
        keep(self, positive, "width", "height", unit="m")

    @cached_property
    def polygon(self) -> shapely.Polygon:  # noqa: D102
        return shapely.Polygon(arc(0.5, 0.0, 2 * math.pi)[:-1] * [self.width, self.height])

    @property
    def area(self) -> float:  # noqa: D102
        return math.pi * self.width * self.height / 4

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return Symmetry(0 if self.width == self.height else 2, True)

    @property
    def words(self) -> str:  # noqa: D102
        return f"ellipse of {1e3 * self.width:g} x {1e3 * self.height:g} mm"


@dataclass(frozen=True)
class Rectangle(Outline):
    """A rectangle around the origin, its sides along x and y.

    Parameters
    ----------
    width, height : float
        Sides along x and y, m.
    corner_radius : float
        Radius of the rounded corners, m; 0: sharp ones.

    Examples
    --------
    >>> import bilayer
    >>> round(bilayer.Rectangle(0.04, 0.03).area, 6)
    0.0012
    """

    width: float
    height: float
    corner_radius: float = 0.0

    def __post_init__(self) -> None:
        keep(self, positive, "width", "height", unit="m")
        keep(self, not_negative, "corner_radius", unit="m")
        shorter, longer = sorted((self.width, self.height))
        half = shorter / 2
        if longer > LARGEST_RATIO * shorter:
            raise InputError(
                f"width = {self.width:g} m: expected at most {LARGEST_RATIO:g} times the height "
                f"{self.height:g} m, and no less than that part of it"
            )
        if self.corner_radius > half:
            raise InputError(
                f"corner_radius = {self.corner_radius} m: expected at most half of the shorter "
                f"side, {half} m"
            )

    @cached_property
    def polygon(self) -> shapely.Polygon:  # noqa: D102
        half = np.array([self.width, self.height]) / 2
        if self.corner_radius == 0:
            return shapely.Polygon(half * [(-1, -1), (1, -1), (1, 1), (-1, 1)])
        centre = half - self.corner_radius
        quarters = [
            arc(self.corner_radius, k * math.pi / 2, (k + 1) * math.pi / 2) + centre * side
            for k, side in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1)))
        ]
        return shapely.Polygon(without_repeats(np.concatenate(quarters)))

    @property
    def area(self) -> float:  # noqa: D102
        return self.width * self.height - (4 - math.pi) * self.corner_radius**2

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return Symmetry(4 if self.width == self.height else 2, True)

    @property
    def words(self) -> str:  # noqa: D102
        sides = f"rectangle of {1e3 * self.width:g} x {1e3 * self.height:g} mm"
        return sides + (
            f" with corners of {1e3 * self.corner_radius:g} mm radius" if self.corner_radius else ""
        )


@dataclass(frozen=True)
class RegularPolygon(Outline):
    """A regular polygon around the origin, one corner on the positive x axis unless turned.

    Parameters
    ----------
    sides : int
        Number of sides, at least 3.
    outer_radius : float
        From the centre to the corners, m.
    angle : float
        By which it is turned, rad.

    Examples
    --------
    >>> import bilayer
    >>> round(bilayer.RegularPolygon(sides=6, outer_radius=0.02).area, 6)
    0.001039
    """

    sides: int
    outer_radius: float
    angle: float = 0.0

    def __post_init__(self) -> None:
        keep(self, whole, "sides", at_least=3, at_most=MOST_SIDES)
        keep(self, positive, "outer_radius", unit="m")
        keep(self, within, "angle", low=-LARGEST_ANGLE, high=LARGEST_ANGLE)

    @cached_property
    def polygon(self) -> shapely.Polygon:  # noqa: D102
        at = self.angle + 2 * math.pi * np.arange(self.sides) / self.sides
        return shapely.Polygon(self.outer_radius * np.column_stack([np.cos(at), np.sin(at)]))

    @property
    def area(self) -> float:  # noqa: D102
        return self.sides / 2 * self.outer_radius**2 * math.sin(2 * math.pi / self.sides)

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        half_steps = self.angle * self.sides / math.pi
        return Symmetry(self.sides, abs(half_steps - round(half_steps)) < 1e-9)

    @property
    def words(self) -> str:  # noqa: D102
        return f"{self.sides} sides, corners at {1e3 * self.outer_radius:g} mm"


@dataclass(frozen=True)
class Polygon(Outline):
    """Any polygon, with or without holes. It lies where its points say, not around the origin.

    Parameters
    ----------
    points : sequence of (float, float)
        Corners in order, either way around, m; the last is joined to the first.
    holes : sequence of sequence of (float, float)
        Corners of each hole, m.

    Examples
    --------
    >>> import bilayer
    >>> triangle = bilayer.Polygon(((0.0, 0.0), (0.04, 0.0), (0.0, 0.03)))
    >>> round(triangle.area, 6)
    0.0006
    """

    points: Ring
    holes: tuple[Ring, ...] = ()

    def __post_init__(self) -> None:
        keep(self, ring, "points")
        holes = listed("holes", self.holes)
        checked = tuple(ring(f"holes[{k}]", hole) for k, hole in enumerate(holes))
        object.__setattr__(self, "holes", checked)
        if not self.polygon.is_valid:
            why = shapely.is_valid_reason(self.polygon)
            raise InputError(f"points: make no polygon in one piece ({why}), m")

    @cached_property
    def polygon(self) -> shapely.Polygon:  # noqa: D102
        return shapely.Polygon(self.points, self.holes)

    @property
    def centroid(self) -> tuple[float, float]:  # noqa: D102
        centre = self.polygon.centroid
        return centre.x, centre.y

    @property
    def symmetry(self) -> Symmetry:
        """None is looked for."""
        return Symmetry(1, False)

    @property
    def words(self) -> str:  # noqa: D102
        holes = f" and {len(self.holes)} holes" if self.holes else ""
        return f"polygon of {len(self.points)} corners{holes}, {1e6 * self.area:g} mm2"


OUTLINES: dict[str, type] = {
    "disc": Disc,
    "ellipse": Ellipse,
    "rectangle": Rectangle,
    "regular-polygon": RegularPolygon,
    "polygon": Polygon,
}
"""By the name of the shape in a specimen file."""


def arc(radius: float, first: float, last: float) -> NDArray[np.float64]:
    """Return points of an arc around the origin, both ends among them, m, shape (k, 2)."""
    count = max(2, 1 + math.ceil(abs(last - first) / (2 * math.pi) * SEGMENTS - 1e-9))
    at = np.linspace(first, last, count)
    return radius * np.column_stack([np.cos(at), np.sin(at)])


def without_repeats(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the corners of a ring without those that lie on the one before, shape (k, 2)."""
    apart = np.linalg.norm(points - np.roll(points, 1, axis=0), axis=1)
    return points[apart > 1e-12 * np.ptp(points, axis=0).max()]


def ring(field: str, points: Iterable[Sequence[float]]) -> Ring:
    """Return the corners of a simple ring as pairs of floats.

    Raises
    ------
    InputError
        Fewer than three, no pairs of numbers, or a ring that crosses itself.
    """
    corners = []
    for k, point in enumerate(listed(field, points)):
        pair = listed(f"{field}[{k}]", point)
        if len(pair) != 2:
            raise InputError(f"{field}[{k}] = {pair}: expected a pair [x, y]")
        corners.append((finite(f"{field}[{k}]", pair[0]), finite(f"{field}[{k}]", pair[1])))
    if len(corners) < 3:
        raise InputError(f"{field}: has {len(corners)} corners, expected at least 3")
    if not shapely.Polygon(corners).is_valid:
        why = shapely.is_valid_reason(shapely.Polygon(corners))
        raise InputError(f"{field}: expected a ring that does not cross itself ({why})")
    return tuple(corners)


def pieces_of(region: shapely.Geometry) -> list[shapely.Polygon]:
    """Return the polygons of a region; points and lines, such as of an intersection, are none."""
    pieces = getattr(region, "geoms", [region])
    return [piece for piece in pieces if piece.geom_type == "Polygon" and piece.area > 0]


def rings_of(region: shapely.Geometry) -> list[list[tuple[float, float]]]:
    """Return the corners of all edges of a region, each once, m; of each piece the outer first."""
    pieces = pieces_of(region)
    edges = [edge for piece in pieces for edge in (piece.exterior, *piece.interiors)]
    return [[(float(x), float(y)) for x, y, *_ in edge.coords[:-1]] for edge in edges]
