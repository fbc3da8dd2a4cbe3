"""Shapes from which the search for stable shapes begins.

Domes, rolled sheets about several axes, and waves are given curvatures over the whole range that a
sheet of this size can take; then come random smooth shapes. They are near no equilibrium: what
counts is that they lie in many valleys of the energy.
"""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.outline import Symmetry

Array = NDArray[np.float64]

CURVATURES = (-3.0, 3.0, -2.0, 2.0, -0.8, 0.8)
"""Of rolled sheets, times the characteristic length: half a turn of a disc is 1.6."""
DOMES = (-1.2, 1.2)
"""Curvatures of domes, times the characteristic length."""
AXES = 3
"""Of rolled sheets, in that part of the plane whose images are all of it."""
AXES_OF_A_SHEET = 5
"""Of one without symmetry."""
WAVES = (2, 3, 4, 5, 6)
"""Around the rim."""
RANDOM_WAVES = 7
"""Around the rim and less, of a random shape."""
RANDOM_BENDS = 2
"""Along the radius, of each of these."""


@dataclass(frozen=True, eq=False)
class Start:
    """A start of the search.

    Parameters
    ----------
    name : str
        One of its own in a search.
    make_shape : callable
        Returns the shape, (n, 3), m.
    avoids_known : bool
        Whether the shapes that are known by then are avoided (deflation).
    """

    name: str
    make_shape: Callable[[], Array]
    avoids_known: bool = False


class Sheet:
    """The flat sheet in polar coordinates about its centroid, over its characteristic length.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the sheet.
    length : float
        Characteristic length of the specimen, m.
    """

    def __init__(self, mesh: PlanarMesh, length: float) -> None:
        self.length = length
        self._points = (mesh.points - mesh.centroid) / length
        self._radius = np.hypot(*self._points.T)
        self._angle = np.arctan2(self._points[:, 1], self._points[:, 0])

    def dome(self, curvature: float) -> Array:
        """Return a spherical cap of equal meridians, m; the curvature is over the length."""
        along = self._radius * curvature
        outward = np.sinc(along / math.pi)  # sin(along) / along
        height = (1 - np.cos(along)) / curvature
        return self.length * np.column_stack([outward[:, None] * self._points, height])

    def rolled(self, axis: float, curvature: float) -> Array:
        """Return a sheet rolled about an axis in its plane, m; the curvature is over the length."""
        turn = np.array([[math.sin(axis), -math.cos(axis)], [math.cos(axis), math.sin(axis)]])
        across, along = turn @ self._points.T
        rolled = np.stack([np.sin(curvature * across) / curvature, along])
        height = (1 - np.cos(curvature * across)) / curvature
        return self.length * np.column_stack([(turn.T @ rolled).T, height])

    def waves(self, count: int, height: float) -> Array:
        """Return a sheet with waves around its rim, m; the height is over the length."""
        return self.raised(height * np.cos(count * self._angle) * self._radius**2)

    def raised(self, height: Array) -> Array:
        """Return the flat sheet with its nodes at heights over the length, m."""
        return self.length * np.column_stack([self._points, height])

    def random(self, seed: int) -> Array:
        """Return a random smooth shape, m: waves, rolled up or not."""
        rng = np.random.default_rng(seed)
        waves = self._random_waves(rng) * rng.uniform(0.1, 0.8)
        if seed % 2:
            return self.raised(waves)
        bent = self.rolled(rng.uniform(0, math.pi), rng.choice((-1, 1)) * rng.uniform(0.5, 3.2))
        bent[:, 2] += 0.3 * self.length * waves
        return bent

    def _random_waves(self, rng: np.random.Generator) -> Array:
        """Return a random smooth function whose largest absolute value is 1."""
        total = np.zeros(len(self._radius))
        for count in range(RANDOM_WAVES):
            for bend in range(RANDOM_BENDS):
                size, phase = rng.normal() / (1 + 0.3 * count), rng.uniform(0, 2 * math.pi)
                power = max(count + 2 * bend, 2)
                total += size * np.cos(count * self._angle + phase) * self._radius**power
        return np.asarray(total / np.abs(total).max())


def fixed_starts(sheet: Sheet, symmetry: Symmetry) -> Iterator[Start]:
    """Yield the starts that every search has, in their order.

    Parameters
    ----------
    sheet : Sheet
        The flat sheet.
    symmetry : Symmetry
        Of the specimen; axes of rolling are not taken twice.
    """
    for curvature in DOMES:
        yield Start(f"dome {curvature:+g}", lambda c=curvature: sheet.dome(c))  # type: ignore[misc]
    for curvature in CURVATURES:
        for axis in rolling_axes(symmetry):
            name = f"rolled {curvature:+g} about {math.degrees(axis):.0f} deg"
            yield Start(name, lambda a=axis, c=curvature: sheet.rolled(a, c))  # type: ignore[misc]
    for count in WAVES:
        yield Start(f"{count} waves", lambda n=count: sheet.waves(n, 0.3))  # type: ignore[misc]


def random_start(sheet: Sheet, seed: int) -> Start:
    """Return the random start of a seed."""
    return Start(f"random {seed}", lambda: sheet.random(seed))


def rolling_axes(symmetry: Symmetry) -> list[float]:
    """Return angles of axes, rad, from 0 on, no two of which are images of each other.

    Examples
    --------
    >>> [round(angle, 4) for angle in rolling_axes(Symmetry(6, True))]
    [0.0, 0.2618, 0.5236]
    >>> rolling_axes(Symmetry(0, True))
    [0.0]
    """
    if symmetry.turns == 0:
        return [0.0]
    directions = math.lcm(symmetry.turns, 2)  # an axis turned by half a turn is itself
    part = 2 * math.pi / directions
    if symmetry.mirrored:
        return [float(angle) for angle in np.linspace(0, part / 2, AXES)]
    count = AXES if symmetry.turns > 1 else AXES_OF_A_SHEET
    return [float(part * k / count) for k in range(count)]
