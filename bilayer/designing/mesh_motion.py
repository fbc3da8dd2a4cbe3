"""The motion of a planar mesh with outline and cuts, so that a design changes without remeshing.

The sheet is described around the origin. Between the angles of the cuts at a radius, angles go
linearly along; between the inner radius, the knots of a profile and the rim, so do radii. Within
the inner radius the turn fades to none at the centre. Nodes on cuts, their knots and the rim stay
on them, but for knots that lie beyond the rim at some angle.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.specimen.density_field import DensityField
from bilayer.specimen.outline import Disc, Outline
from bilayer.specimen.pattern import CutPattern, Pattern, SectorProfile
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

TURN = 2 * math.pi
PASSES = 12
"""Of the search for a place whose radius and angle depend on each other; a disc needs one."""


def move_points(points: Array, before: Specimen, after: Specimen) -> Array:
    """Return where points of a flat sheet lie after its outline and cuts have changed.

    Parameters
    ----------
    points : (n, 2) array of float
        On the sheet of `before`, m.
    before, after : Specimen
        With the same kinds of outline and pattern.

    Returns
    -------
    (n, 2) array of float
        m; the points themselves if nothing has changed.

    Raises
    ------
    InputError
        The sheet has cuts that are not described around the origin.
    """
    if _geometry(before) == _geometry(after):
        return points
    return PolarSheet.of(before).move_to(PolarSheet.of(after), points)


def _geometry(specimen: Specimen) -> tuple[Outline, tuple[Pattern | None, ...]]:
    return specimen.outline, _cuts(specimen)


def _cuts(specimen: Specimen) -> tuple[Pattern | None, ...]:
    """Return the pattern of each layer; a field of density cuts nothing."""
    patterns = [layer.pattern for layer in specimen.layers]
    return tuple(None if isinstance(each, DensityField) else each for each in patterns)


@dataclass(frozen=True)
class PolarSheet:
    """A sheet around the origin, cut by sectors.

    Parameters
    ----------
    outline : Outline
        Star-shaped about the origin.
    cut : CutPattern, SectorProfile or None
        The cuts.
    """

    outline: Outline
    cut: CutPattern | SectorProfile | None

    @classmethod
    def of(cls, specimen: Specimen) -> "PolarSheet":
        """Return the sheet of a specimen."""
        cut: Any = next((each for each in _cuts(specimen) if each is not None), None)
        if not cls.is_known(specimen):
            raise InputError(
                "pattern: expected one of the kinds 'sectors' and 'sector-profile', whose mesh can "
                "be moved"
            )
        return cls(specimen.outline, cut)

    @staticmethod
    def is_known(specimen: Specimen) -> bool:
        """Whether the cuts of a specimen are of a kind whose mesh can be moved."""
        cuts = {*_cuts(specimen)} - {None}
        return len(cuts) <= 1 and all(isinstance(c, CutPattern | SectorProfile) for c in cuts)

    @property
    def inner_radius(self) -> float:
        """Where the cuts begin, m; 0 without cuts."""
        match self.cut:
            case CutPattern():
                return self.cut.inner_radius
            case SectorProfile():
                return self.cut.radii[0]
        return 0.0

    @property
    def knots(self) -> Array:
        """The radii at which the cuts may bend, from where they begin, ascending, m."""
        radii = self.cut.radii if isinstance(self.cut, SectorProfile) else (self.inner_radius,)
        return np.array(radii, dtype=float)

    @property
    def least_reach(self) -> float:
        """The least distance of the rim from the origin, m; of a polygon, at whole degrees."""
        around: Array = np.asarray(np.linspace(0.0, TURN, 361)[:-1])
        return float(self.reach(around).min())

    def edge_angles(self, radius: Array) -> Array:
        """Return the angles of the cuts' edges at some radii, ascending, rad, shape (n, 2 cuts)."""
        match self.cut:
            case CutPattern():
                half, strips = np.full_like(radius, self.cut.cutout_angle / 2), self.cut.strips
            case SectorProfile():
                half, strips = self.cut.half_angle(radius), self.cut.strips
            case _:
                return np.empty((len(radius), 0))
        centres = TURN * (np.arange(strips) + 0.5) / strips
        edges = centres[:, None] + np.multiply.outer(half, [[-1.0, 1.0]])
        return edges.reshape(len(radius), -1)

    def reach(self, angle: Array) -> Array:
        """Return the distance of the rim from the origin at some angles, m, shape (n,)."""
        if isinstance(self.outline, Disc):
            return np.full_like(angle, self.outline.radius)
        corners = shapely.get_coordinates(self.outline.polygon.exterior)[:-1]
        around = np.arctan2(corners[:, 1], corners[:, 0]) % TURN
        order = np.argsort(around)
        corners, around = corners[order], around[order]
        first = np.searchsorted(around, angle % TURN, side="right") - 1
        start, end = corners[first], corners[(first + 1) % len(corners)]
        along, way = end - start, np.column_stack([np.cos(angle), np.sin(angle)])
        return _cross(start, along) / _cross(way, along)

    def move_to(self, after: "PolarSheet", points: Array) -> Array:
        """Return where points lie on another sheet of the same cuts, m, shape (n, 2)."""
        x, y = points.T
        radius, angle = np.hypot(x, y), np.arctan2(y, x) % TURN
        inner, inner_after = self.inner_radius, after.inner_radius
        knots, knots_after = _common_knots(self, after)
        last, last_after = knots[-1], knots_after[-1]
        share = (radius - last) / (self.reach(angle) - last)
        within = radius / inner if inner else np.ones_like(radius)
        between = np.interp(radius, knots, knots_after)
        fade = np.minimum(within, 1.0)
        edges = self.edge_angles(np.maximum(radius, inner))
        moved_angle, moved_radius = angle, radius
        for _ in range(1 if isinstance(after.outline, Disc) else PASSES):
            beyond = last_after + share * (after.reach(moved_angle) - last_after)
            moved_radius = np.where(radius < last, between, beyond)
            moved_radius = np.where(radius < inner, within * inner_after, moved_radius)
            there = after.edge_angles(np.maximum(moved_radius, inner_after))
            moved_angle = angle + fade * (_between_edges(angle, edges, there) - angle)
        away = np.column_stack([np.cos(moved_angle), np.sin(moved_angle)])
        return moved_radius[:, None] * away


def _common_knots(before: PolarSheet, after: PolarSheet) -> tuple[Array, Array]:
    """Return the knots that lie within the rim at all angles, before and after; at least one."""
    knots, knots_after = before.knots, after.knots
    within = (knots < before.least_reach) & (knots_after < after.least_reach)
    count = max(int(np.argmin(within)) if not within.all() else len(within), 1)
    return knots[:count], knots_after[:count]


def _between_edges(angle: Array, before: Array, after: Array) -> Array:
    """Return angles that lie between the same edges, at the same share of the way, (n,)."""
    if before.shape[1] == 0:
        return angle
    rows = np.arange(len(angle))
    before, after = (
        np.column_stack([edges[:, -1] - TURN, edges, edges[:, 0] + TURN])
        for edges in (before, after)
    )
    first = np.clip((before <= angle[:, None]).sum(axis=1) - 1, 0, before.shape[1] - 2)
    start, width = before[rows, first], before[rows, first + 1] - before[rows, first]
    there, wide = after[rows, first], after[rows, first + 1] - after[rows, first]
    return there + (angle - start) * wide / np.where(width > 0, width, 1.0)


def _cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
