"""The kinds of patterns by their names in a specimen file."""

from bilayer.specimen.density_field import DensityField
from bilayer.specimen.pattern import Contours, Cross, CutPattern, Polygons, SectorProfile

PATTERNS: dict[str, type] = {
    "sectors": CutPattern,
    "sector-profile": SectorProfile,
    "polygons": Polygons,
    "contours": Contours,
    "cross": Cross,
    "density-field": DensityField,
}
"""The class of each kind."""
