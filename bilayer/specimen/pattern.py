"""The pattern of a layer: where on the sheet it lies, the rest of it being cut away.

A pattern is a frozen dataclass that says with shapely which part of an outline it keeps. Sectors
and profiles are measured around the origin.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.drawings.contours import even_odd, place
from bilayer.errors import InputError
from bilayer.specimen.outline import Disc, Outline, Ring, Symmetry, arc, ring, rings_of
from bilayer.validation import finite, keep, listed, not_negative, one_of, positive, whole

KEPT_OR_CUT = ("kept", "cut")
MOST_STRIPS = 1000


class Pattern(Protocol):
    """The part of the outline on which a layer lies.

    Examples
    --------
    >>> import bilayer, shapely
    >>> ring = shapely.Point(0, 0).buffer(0.03) - shapely.Point(0, 0).buffer(0.02)
    >>> pattern = bilayer.Pattern.from_geometry(ring)
    >>> specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=pattern)
    """

    def kept(self, outline: Outline) -> shapely.Geometry:
        """Return the part of an outline where the layer lies."""

    def check_fit(self, outline: Outline) -> None:
        """Raise InputError unless some of the outline is kept and some is cut away."""
        share = kept_share(self, outline)
        if not 1e-9 < share < 1 - 1e-9:
            what = "all" if share > 0.5 else "none"
            raise InputError(f"kept = {what} of the outline: expected a part of it")

    @property
    def symmetry(self) -> Symmetry:
        """The motions that leave it unchanged."""

    @property
    def words(self) -> str:
        """Description for a report, lengths in mm."""

    @property
    def identity(self) -> str:
        """A text that two patterns share if they are the same."""
        return repr(self)

    @staticmethod
    def from_geometry(geometry: shapely.Geometry, what: str = "kept") -> "Contours":
        """Return the pattern that keeps, or cuts, a geometry of shapely.

        Parameters
        ----------
        geometry : Polygon or MultiPolygon
            m.
        what : {"kept", "cut"}
            What it is.

        Examples
        --------
        >>> import shapely
        >>> ring = shapely.Point(0, 0).buffer(0.03) - shapely.Point(0, 0).buffer(0.02)
        >>> Pattern.from_geometry(ring).words
        '2 contours kept'
        """
        if not isinstance(geometry, (shapely.Polygon, shapely.MultiPolygon)) or geometry.is_empty:
            raise InputError(f"geometry = {geometry}: expected a Polygon or MultiPolygon")
        return Contours(tuple(map(tuple, rings_of(geometry))), what)


@dataclass(frozen=True)
class CutPattern(Pattern):
    """Equal sectors cut out of a layer, from the inner radius to the rim.

    Cutout k of n is centred at the angle 2 pi (k + 1/2) / n, so the first strip's centre line
    is the x axis.

    Parameters
    ----------
    strips : int
        Number of strips, as many as cutouts.
    inner_radius : float
        Where the cutouts begin, m.
    cutout_angle : float
        Central angle of one cutout (the paper's dTheta), rad.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.CutPattern(strips=5, inner_radius=0.008, cutout_angle=0.3).words
    '5 strips, cutouts of 0.3 rad from 8 mm outward'
    """

    strips: int
    inner_radius: float
    cutout_angle: float

    def __post_init__(self) -> None:
        _check_strips(self)
        keep(self, positive, "inner_radius", unit="m")
        keep(self, positive, "cutout_angle", unit="rad")
        widest = 2 * math.pi / self.strips
        if self.cutout_angle >= widest:
            raise InputError(
                f"cutout_angle = {self.cutout_angle} rad: {self.strips} cutouts need less "
                f"than 2*pi/{self.strips} = {widest:.4g} rad each, or they overlap "
                "(degrees as '20 deg')"
            )

    @property
    def cutout_centres(self) -> list[float]:
        """Angles of the cutouts' centre lines, rad."""
        return _cutout_centres(self.strips)

    def kept(self, outline: Outline) -> shapely.Geometry:  # noqa: D102
        half = self.cutout_angle / 2
        inner = arc(self.inner_radius, -half, half)
        outer = arc(_beyond(outline), half, -half)
        return _without_cutouts(outline, self.strips, np.concatenate([inner, outer]))

    def check_fit(self, outline: Outline) -> None:
        """Raise InputError unless the cutouts begin within the outline."""
        if isinstance(outline, Disc) and self.inner_radius >= outline.radius:
            raise InputError(
                f"inner_radius = {self.inner_radius} m: expected less than "
                f"specimen.outer_radius = {outline.radius} m"
            )
        super().check_fit(outline)

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return Symmetry(self.strips, True)

    @property
    def words(self) -> str:  # noqa: D102
        inner = 1e3 * self.inner_radius
        return (
            f"{self.strips} strips, cutouts of {self.cutout_angle:g} rad from {inner:g} mm outward"
        )


@dataclass(frozen=True)
class SectorProfile(Pattern):
    """Equal cutouts from the inner radius to the rim, their half-angle a function of the radius.

    Between the given radii the half-angle is smooth and has no extremum of its own (a monotone
    cubic, PCHIP); beyond the last one it stays. Cutouts lie as those of `CutPattern`.

    Parameters
    ----------
    strips : int
        Number of strips, as many as cutouts.
    radii : sequence of float
        Ascending, at least two, m; the cutouts begin at the first.
    half_angles : sequence of float
        Half of a cutout's central angle at each radius, rad; from 0 (the cutout begins as a point)
        to less than pi / strips.

    Examples
    --------
    >>> import bilayer
    >>> petals = bilayer.SectorProfile(6, radii=(0.006, 0.022), half_angles=(0.05, 0.25))
    >>> petals.kept(bilayer.Disc(0.03)).area < bilayer.Disc(0.03).area
    True
    """

    strips: int
    radii: tuple[float, ...]
    half_angles: tuple[float, ...]

    def __post_init__(self) -> None:
        _check_strips(self)
        radii = tuple(positive("radii", value, "m") for value in listed("radii", self.radii))
        if len(radii) < 2 or any(b <= a for a, b in pairwise(radii)):
            raise InputError(f"radii = {list(radii)}: expected at least two, ascending, m")
        given = listed("half_angles", self.half_angles)
        angles = tuple(not_negative("half_angles", value, "rad") for value in given)
        if len(angles) != len(radii):
            raise InputError(
                f"half_angles: has {len(angles)} values, expected one for each of the "
                f"{len(radii)} radii"
            )
        widest = math.pi / self.strips
        if max(angles) >= widest or max(angles) == 0:
            raise InputError(
                f"half_angles = {list(angles)} rad: {self.strips} cutouts need a largest one "
                f"above 0 and below pi/{self.strips} = {widest:.4g} rad, or they overlap"
            )
        object.__setattr__(self, "radii", radii)
        object.__setattr__(self, "half_angles", angles)

    def half_angle(self, radius: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the half-angle of a cutout at some radii from the first on, rad."""
        from scipy.interpolate import PchipInterpolator  # seldom needed, slow to load

        within = np.clip(radius, self.radii[0], self.radii[-1])
        return np.asarray(PchipInterpolator(self.radii, self.half_angles)(within))

    def kept(self, outline: Outline) -> shapely.Geometry:  # noqa: D102
        last = self.radii[-1]
        steps = [np.linspace(a, b, 65)[:-1] for a, b in pairwise(self.radii)]
        radius = np.concatenate([*steps, [last]])
        angle = self.half_angle(radius)
        far = max(_beyond(outline), 2 * last)
        side = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
        outer = arc(far, angle[-1], -angle[-1]) if angle[-1] > 0 else np.empty((0, 2))
        inner = arc(self.radii[0], -angle[0], angle[0])[1:-1] if angle[0] > 0 else side[:0]
        other = side[::-1] * [1, -1]
        if angle[0] == 0:
            other = other[:-1]  # both sides begin at one point
        return _without_cutouts(outline, self.strips, np.concatenate([side, outer, other, inner]))

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        return Symmetry(self.strips, True)

    @property
    def words(self) -> str:  # noqa: D102
        inner, angles = 1e3 * self.radii[0], (2 * min(self.half_angles), 2 * max(self.half_angles))
        spread = f"{angles[0]:g} to {angles[1]:g} rad"
        return f"{self.strips} strips, cutouts of {spread} from {inner:g} mm outward"


@dataclass(frozen=True)
class Polygons(Pattern):
    """Polygons, as what is kept of a layer or as what is cut out of it.

    Parameters
    ----------
    polygons : sequence of sequence of (float, float)
        Corners of each, m; together they are their union.
    what : {"kept", "cut"}
        What they are.

    Examples
    --------
    >>> import bilayer
    >>> window = ((-0.01, -0.01), (0.01, -0.01), (0.01, 0.01), (-0.01, 0.01))
    >>> around = bilayer.Polygons((window,), "cut").kept(bilayer.Rectangle(0.04, 0.04))
    >>> round(around.area, 6)
    0.0012
    """

    polygons: tuple[Ring, ...]
    what: str = "kept"

    def __post_init__(self) -> None:
        given = listed("polygons", self.polygons)
        if not given:
            raise InputError("polygons = []: expected at least one")
        rings = tuple(ring(f"polygons[{k}]", points) for k, points in enumerate(given))
        object.__setattr__(self, "polygons", rings)
        keep(self, one_of, "what", choices=KEPT_OR_CUT)

    @cached_property
    def _union(self) -> shapely.Geometry:
        return shapely.union_all([shapely.Polygon(points) for points in self.polygons])

    def kept(self, outline: Outline) -> shapely.Geometry:  # noqa: D102
        if self.what == "kept":
            return shapely.intersection(outline.polygon, self._union)
        return shapely.difference(outline.polygon, self._union)

    @property
    def symmetry(self) -> Symmetry:
        """None is looked for."""
        return Symmetry(1, False)

    @property
    def words(self) -> str:  # noqa: D102
        return f"{len(self.polygons)} polygons {self.what}"


@dataclass(frozen=True)
class Contours(Pattern):
    """What lies within an odd number of closed contours, as what is kept or as what is cut.

    A contour within another is a hole of it, one within the hole an island.

    Parameters
    ----------
    contours : sequence of sequence of (float, float)
        Points of each, m; they do not cross each other.
    what : {"kept", "cut"}
        What they bound.

    Examples
    --------
    >>> import bilayer
    >>> square = ((-0.01, -0.01), (0.01, -0.01), (0.01, 0.01), (-0.01, 0.01))
    >>> round(bilayer.Contours((square,)).kept(bilayer.Disc(0.04)).area, 6)
    0.0004
    """

    contours: tuple[Ring, ...]
    what: str = "kept"

    def __post_init__(self) -> None:
        given = listed("contours", self.contours)
        if not given:
            raise InputError("contours = []: expected at least one")
        rings = tuple(ring(f"contours[{k}]", points) for k, points in enumerate(given))
        object.__setattr__(self, "contours", rings)
        keep(self, one_of, "what", choices=KEPT_OR_CUT)

    @cached_property
    def _region(self) -> shapely.Geometry:
        return even_odd([np.array(points) for points in self.contours])

    def kept(self, outline: Outline) -> shapely.Geometry:  # noqa: D102
        if self.what == "kept":
            return shapely.intersection(outline.polygon, self._region)
        return shapely.difference(outline.polygon, self._region)

    def check_fit(self, outline: Outline) -> None:
        """Raise InputError unless each contour lies on the sheet, at least in part."""
        for points in self.contours:
            if not shapely.intersects(outline.polygon, shapely.Polygon(points)):
                x, y = np.mean(points, axis=0)
                raise InputError(
                    f"contours: one lies outside of the sheet, around {place((x, y))}, expected "
                    "all of them on it"
                )
        super().check_fit(outline)

    @property
    def symmetry(self) -> Symmetry:
        """None is looked for."""
        return Symmetry(1, False)

    @property
    def words(self) -> str:  # noqa: D102
        return f"{len(self.contours)} contours {self.what}"


@dataclass(frozen=True)
class Cross(Pattern):
    """Two bars that cross at the origin, kept; the layer is cut away between them.

    Parameters
    ----------
    arm_width : float
        Width of the bars, m.
    arm_length : float or None
        From one end of a bar to the other, m; None: from rim to rim.
    angle : float
        Of the first bar from the x axis, rad.

    Examples
    --------
    >>> import bilayer
    >>> cross = bilayer.Cross(arm_width=0.004, arm_length=0.03)
    >>> round(cross.kept(bilayer.Rectangle(0.04, 0.04)).area, 6)
    0.000224
    """

    arm_width: float
    arm_length: float | None = None
    angle: float = 0.0

    def __post_init__(self) -> None:
        keep(self, positive, "arm_width", unit="m")
        keep(self, finite, "angle")
        if self.arm_length is not None:
            keep(self, positive, "arm_length", unit="m")
            if self.arm_length <= self.arm_width:
                raise InputError(
                    f"arm_length = {self.arm_length} m: expected more than "
                    f"arm_width = {self.arm_width} m"
                )

    def kept(self, outline: Outline) -> shapely.Geometry:  # noqa: D102
        length = 2 * _beyond(outline) if self.arm_length is None else self.arm_length
        half = np.array([length, self.arm_width]) / 2
        bar = half * [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        bars = [shapely.Polygon(turned(bar, self.angle + k * math.pi / 2)) for k in (0, 1)]
        return shapely.intersection(outline.polygon, shapely.union_all(bars))

    @property
    def symmetry(self) -> Symmetry:  # noqa: D102
        eighths = self.angle / (math.pi / 4)
        return Symmetry(4, abs(eighths - round(eighths)) < 1e-9)

    @property
    def words(self) -> str:  # noqa: D102
        return f"a cross of bars {1e3 * self.arm_width:g} mm wide"


def kept_share(pattern: Pattern | None, outline: Outline) -> float:
    """Return the part of the outline's area where a layer lies, from 0 to 1; None: all of it."""
    if pattern is None:
        return 1.0
    return _kept_share(pattern, outline)  # type: ignore[arg-type]  # both are frozen dataclasses


@lru_cache(maxsize=64)  # every specimen asks, and most that are made differ in other things
def _kept_share(pattern: Pattern, outline: Outline) -> float:
    return float(pattern.kept(outline).area / outline.polygon.area)


def turned(points: NDArray[np.float64], angle: float) -> NDArray[np.float64]:
    """Return points turned about the origin by an angle in rad, shape (k, 2)."""
    c, s = math.cos(angle), math.sin(angle)
    return points @ np.array([[c, s], [-s, c]])


def _check_strips(pattern: Any) -> None:
    if pattern.strips == 0:
        raise InputError("strips = 0: leave the pattern out for a whole layer, expected at least 1")
    keep(pattern, whole, "strips", at_least=1, at_most=MOST_STRIPS)


def _cutout_centres(strips: int) -> list[float]:
    return [2 * math.pi * (k + 0.5) / strips for k in range(strips)]


def _without_cutouts(
    outline: Outline, strips: int, cutout: NDArray[np.float64]
) -> shapely.Geometry:
    """Return the outline without a cutout that is drawn around the x axis, at all their places."""
    cutouts = [shapely.Polygon(turned(cutout, middle)) for middle in _cutout_centres(strips)]
    return shapely.difference(outline.polygon, shapely.union_all(cutouts))


def _beyond(outline: Outline) -> float:
    """Return a radius around the origin, beyond all of the outline, m."""
    x0, y0, x1, y1 = outline.polygon.bounds
    return 2 * math.hypot(max(-x0, x1), max(-y0, y1))
