"""Flat sheets of several outlines and patterns, as bilayers and as trilayers, for several tests."""

import math

from bilayer import MeshSize, MooneyRivlin, Specimen
from bilayer.specimen.layer import Layer, Response
from bilayer.specimen.outline import Disc, Ellipse, Polygon, Rectangle
from bilayer.specimen.pattern import Cross, CutPattern, SectorProfile
from bilayer.specimen.prestretch import Prestretch

R = 0.02
SOFT = MooneyRivlin(22_060.0, 1_656.0, 1e-5)
STIFF = MooneyRivlin(17_880.0, 84_450.0, 1e-5)
"""Laws of a published bistable sheet's substrate and kirigami layers."""

CUT_SHEETS = {
    "square": (Rectangle(2 * R, 2 * R), Cross(R / 3)),
    "cross": (Rectangle(2 * R, 2 * R, 0.2 * R), Cross(R / 6, 1.8 * R)),
    "ellipse": (
        Ellipse(2.5 * R, 1.6 * R),
        SectorProfile(6, (0.25 * R, 0.6 * R, R), (0.07, 0.12, 0.25)),
    ),
    "lotus": (Disc(R), CutPattern(10, 0.55 * R, math.radians(14.4))),
}
"""Outline and pattern."""

CORNER = Polygon(((0, 0), (2, 0), (2, 0.7), (0.7, 0.7), (0.7, 2), (0, 2)))
"""An L, away from the origin."""


def pile_of(kind, total, pattern=None):
    """Return the layers of a bilayer or a trilayer of a whole thickness, m."""
    stretched = Response("path")
    if kind == "bilayer":
        return (
            Layer("substrate", 0.4 * total, SOFT, response=stretched),
            Layer("kirigami", 0.6 * total, STIFF, pattern=pattern),
        )
    return (
        Layer("lower", 0.25 * total, STIFF, pattern=pattern),
        Layer("substrate", 0.5 * total, SOFT, response=stretched),
        Layer("upper", 0.25 * total, STIFF, pattern=pattern),
    )


def sheet_of(outline, layers, milestones=(1.06,), size=None):
    """Return a specimen whose mesh has a few hundred triangles."""
    size = outline.characteristic_length / 6 if size is None else size
    return Specimen(outline, layers, Prestretch(milestones), MeshSize(size))
