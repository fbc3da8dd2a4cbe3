"""A shallow cylindrical roof, hinged along its straight edges, under a force at its centre.

Sze, Liu and Lo, "Popular benchmark problems for geometric nonlinear analysis of shells", Finite
Elem. Anal. Des. 40 (2004), tables 9: the force at deflections of the thick roof up to its first
limit point, and the first limit points of both. SI units.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from verification.arc_length import Loaded, PathPoint, Scales, State, follow_arc
from verification.rung import Check

Array = NDArray[np.float64]

RADIUS, HALF_ANGLE, LENGTH = 2.54, 0.1, 0.508  # m, rad, m
YOUNG, POISSON = 3102.75e6, 0.3  # Pa
WORDS = (
    "Radius 2540 mm, 508 x 508 mm, E = 3102.75 MPa, nu = 0.3, 12.7 or 6.35 mm thick, hinged along "
    "its straight edges, a force at its centre: through both limit points, by arc length; Sze, Liu "
    "and Lo (2004), table 9."
)
FORCE = 3000.0  # N, which the published forces are shares of
THICK, THIN = 12.7e-3, 6.35e-3  # m
"""Thicknesses. The deflection of the thin roof goes back between its limit points."""
THICK_CURVE = (
    (0.0877, 0.693), (0.1980, 1.638), (0.3473, 3.087), (0.4686, 4.477), (0.5647, 5.802),
    (0.6381, 7.057), (0.6908, 8.237), (0.7246, 9.339), (0.7412, 10.358),
)  # fmt: skip
"""Shares of the force, and deflections, mm."""
FIRST_LIMITS = {THICK: 0.7421, THIN: 0.1953}
"""Largest shares of the force before the roof snaps."""
DEEPEST = 0.029
"""Deflection up to which the curve is followed, m: beyond the second limit point."""


def on_cylinder(points: Array) -> Array:
    """Return flat points, (n, 2) or (n, 3) with their height, m, on the roof, its top at 0."""
    height = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
    angle, radius = points[:, 0] / RADIUS, RADIUS + height
    return np.column_stack([radius * np.sin(angle), points[:, 1], radius * np.cos(angle) - RADIUS])


def scales_of(thickness: float) -> Scales:
    """Return what counts as much as what on the curve of a roof."""
    return Scales(deflection=0.03, force=FORCE * FIRST_LIMITS[thickness], tolerance=1e-4)


def path_of(
    roof: Loaded[State], at_rest: State, thickness: float, step: float
) -> list[PathPoint[State]]:
    """Return the path of a roof from its equilibrium without force, through both limit points."""
    return list(
        follow_arc(roof, at_rest, scales_of(thickness), step, lambda deep, _: deep < DEEPEST)
    )


def curves_of(path: Callable[[float], Sequence[PathPoint[Any]]]) -> dict[float, "Curve"]:
    """Return the curves of both roofs by thickness, from the path of each."""
    return {thickness: Curve(path(thickness)) for thickness in (THICK, THIN)}


@dataclass(frozen=True)
class Turn:
    """A place of a curve where force or deflection turns back: N, m."""

    force: float
    deflection: float


class Curve:
    """The curve of force over deflection through the points of a path, smooth between them."""

    def __init__(self, points: Sequence[PathPoint[Any]]) -> None:
        self._deflections = np.array([0.0, *(point.deflection for point in points)])
        self._forces = np.array([0.0, *(point.force for point in points)])
        places = np.arange(len(points) + 1)
        self._deflection = CubicSpline(places, self._deflections)
        self._force = CubicSpline(places, self._forces)

    def force_at(self, deflection: float) -> float:
        """Return the force where the deflection first has a value."""
        first = np.argmax(self._deflections > deflection)
        place = brentq(lambda t: self._deflection(t) - deflection, first - 1, first)
        return float(self._force(place))

    @property
    def limits(self) -> list[Turn]:
        """The limit points: where the force turns."""
        return self._turns(self._force)

    @property
    def returns(self) -> list[Turn]:
        """Where the deflection turns."""
        return self._turns(self._deflection)

    def _turns(self, spline: CubicSpline) -> list[Turn]:
        places = spline.derivative().roots(extrapolate=False)
        return [Turn(float(self._force(t)), float(self._deflection(t))) for t in places]


def against_the_paper(
    curves: Mapping[float, Curve], case: str, tolerance: float
) -> Iterator[Check]:
    """Yield the checks of the curves of both roofs against the published numbers."""
    for share, deflection in THICK_CURVE:
        found = curves[THICK].force_at(1e-3 * deflection)
        yield Check(f"{case}, thick, {deflection} mm: force (N)", found, share * FORCE, tolerance)
    for thickness, name in ((THICK, "thick"), (THIN, "thin")):
        first = curves[thickness].limits[0].force
        quantity = f"{case}, {name}: force at the first limit point (N)"
        yield Check(quantity, first, FIRST_LIMITS[thickness] * FORCE, tolerance)


def beyond(
    curves: Mapping[float, Curve], others: Mapping[float, Curve], case: str, tolerance: float
) -> Iterator[Check]:
    """Yield what is beyond the first limit points, against the same of another model."""
    for thickness, name in ((THICK, "thick"), (THIN, "thin")):
        found, wanted = (each[thickness].limits[1].force for each in (curves, others))
        quantity = f"{case}, {name}: force at the second limit point (N)"
        yield Check(quantity, found, wanted, tolerance)
    places = zip(curves[THIN].returns, others[THIN].returns, strict=True)
    for (one, other), which in zip(places, ("largest", "least"), strict=True):
        quantity = f"{case}, thin: {which} deflection between (m)"
        yield Check(quantity, one.deflection, other.deflection, tolerance)
