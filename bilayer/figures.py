"""The figures: what is drawn, by name, and how it is saved. Solvers have no use for them."""

from bilayer.figure_file import save_figure
from bilayer.mesh_figure import draw_mesh
from bilayer.quality_figure import (
    draw_comparison,
    draw_distances,
    draw_quality,
    draw_quality_against,
)
from bilayer.shape_figure import draw_birds_eye, draw_isometric, draw_shapes

__all__ = [
    "draw_birds_eye",
    "draw_comparison",
    "draw_distances",
    "draw_isometric",
    "draw_mesh",
    "draw_quality",
    "draw_quality_against",
    "draw_shapes",
    "save_figure",
]
