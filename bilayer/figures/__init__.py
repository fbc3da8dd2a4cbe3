"""The figures: what is drawn, by name, and how it is saved. Solvers have no use for them."""

from bilayer.figures import backend  # noqa: F401  # first: it loads matplotlib
from bilayer.figures.mesh import draw_mesh
from bilayer.figures.quality import (
    draw_comparison,
    draw_distances,
    draw_quality,
    draw_quality_against,
)
from bilayer.figures.saving import save_figure
from bilayer.figures.shape import draw_birds_eye, draw_isometric, draw_shape, draw_shapes

__all__ = [
    "draw_birds_eye",
    "draw_comparison",
    "draw_distances",
    "draw_isometric",
    "draw_mesh",
    "draw_quality",
    "draw_quality_against",
    "draw_shape",
    "draw_shapes",
    "save_figure",
]
