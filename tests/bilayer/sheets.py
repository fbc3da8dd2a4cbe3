"""Outlines, patterns and specimens of every kind, for the tests of several modules."""

import math
from pathlib import Path

from bilayer import (
    Cross,
    CutPattern,
    Disc,
    Ellipse,
    Layer,
    MeshSize,
    MooneyRivlin,
    Polygon,
    Polygons,
    Prestretch,
    Rectangle,
    RegularPolygon,
    Response,
    SectorProfile,
    Specimen,
)

EXAMPLES = Path(__file__).parents[2] / "examples"
EXAMPLE_SPECIMENS = sorted(set(EXAMPLES.glob("*.toml")) - set(EXAMPLES.glob("design_*.toml")))
"""Files of the examples that are specimens: all but those of designs."""
MATERIAL = MooneyRivlin.from_moduli(116_250.0, 0.49)


def square(x, y, half):
    return ((x - half, y - half), (x + half, y - half), (x + half, y + half), (x - half, y + half))


def circle(x, y, radius, corners=60):
    at = [2 * math.pi * k / corners for k in range(corners)]
    return tuple((x + radius * math.cos(a), y + radius * math.sin(a)) for a in at)


OUTLINES = {
    "disc": Disc(0.02),
    "ellipse": Ellipse(0.06, 0.04),
    "rectangle": Rectangle(0.05, 0.04),
    "rounded": Rectangle(0.05, 0.04, 0.008),
    "stadium": Rectangle(0.06, 0.03, 0.015),
    "hexagon": RegularPolygon(6, 0.022),
    "holes": Polygon(
        square(0, 0, 0.02), (square(0.012, 0.012, 0.004), circle(-0.01, -0.01, 0.003))
    ),
    "L": Polygon(((0, 0), (0.04, 0), (0.04, 0.02), (0.02, 0.02), (0.02, 0.04), (0, 0.04))),
}  # fmt: skip
PATTERNS = {
    "whole": None,
    "sectors": CutPattern(5, 0.006, 0.4),
    "pointed profile": SectorProfile(6, (0.005, 0.01, 0.018), (0.0, 0.2, 0.1)),
    "blunt profile": SectorProfile(4, (0.004, 0.02), (0.2, 0.5)),
    "kept polygons": Polygons((square(0.002, 0.002, 0.006), circle(0.012, 0.006, 0.004))),
    "cut polygons": Polygons((circle(0.001, 0, 0.005), square(0.01, 0.004, 0.002)), "cut"),
    "cross": Cross(0.0033),
    "turned cross": Cross(0.004, 0.02, 0.3),
}


def bilayer(outline=OUTLINES["disc"], pattern=None, **options):
    """The sheet of a stretched substrate and a kirigami layer on it."""
    layers = (
        Layer("substrate", 1e-3, MATERIAL, response=Response("path")),
        Layer("kirigami", 1e-3, MATERIAL, pattern=pattern),
    )
    return Specimen(outline, layers, Prestretch((1.05,)), **{"mesh": MeshSize(0.0025), **options})


def trilayer(outline=OUTLINES["disc"], lower=None, upper=None, **options):
    """The sheet of a stretched substrate between two kirigami layers."""
    layers = (
        Layer("lower", 1.6e-3, MATERIAL, 1000.0, lower),
        Layer("substrate", 1.1e-3, MATERIAL, response=Response("path")),
        Layer("upper", 1.6e-3, MATERIAL, 1000.0, upper),
    )
    return Specimen(outline, layers, Prestretch((1.05,)), **{"mesh": MeshSize(0.0025), **options})


def drawn_sheet(folder, pattern, outline='outer_radius = "40 mm"'):
    """A specimen file whose kirigami has a pattern, as TOML; its path."""
    path = folder / "sheet.toml"
    path.write_text(
        f"""
[specimen]
{outline}
[[layers]]
name = "substrate"
thickness = "1 mm"
material = "soft"
response = "path"
[[layers]]
name = "kirigami"
thickness = "1 mm"
material = "soft"
pattern = {pattern}
[materials.soft]
young_modulus = "116.25 kPa"
poisson_ratio = 0.49
[prestretch]
milestones = [1.03]
[mesh]
size = "6 mm"
""",
        encoding="utf-8",
    )
    return path
