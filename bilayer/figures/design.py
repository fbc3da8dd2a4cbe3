"""A design's shape beside its target, and the way of the search."""

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bilayer.figures.shape import ISOMETRIC, View
from bilayer.figures.style import RESULT_COLOURS, new_figure, print_style
from bilayer.geometry.surface import Surface
from bilayer.results.released_shapes import MM_PER_M

Array = NDArray[np.float64]

SIDE = View(-math.pi / 2, math.radians(5))


def draw_target(shape: Surface, target: Surface, distances: Array) -> Figure:
    """Draw a shape and its target in two views, the shape coloured by its distance from it.

    Parameters
    ----------
    shape : Surface
        The shape, m.
    target : Surface
        The target, placed beside it as well as it can be, m.
    distances : (m,) array of float
        Of the shape's triangles from the target, m.
    """
    largest = MM_PER_M * float(distances.max()) or 1.0
    arms = [surface.points - surface.centroid for surface in (shape, target)]
    reach = 1.02 * MM_PER_M * max(float(np.linalg.norm(arm, axis=1).max()) for arm in arms)
    with print_style():
        figure = new_figure(7.0, 5.2)
        panels = figure.subplots(2, 2)
        for row, view in zip(panels, (ISOMETRIC, SIDE), strict=True):
            beside, on = row
            _fill(beside, target, view, np.full(len(target.triangles), np.nan), largest)
            drawn = _fill(on, shape, view, MM_PER_M * distances, largest)
        for axes in panels.flat:
            axes.set(xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal")
            axes.set_axis_off()
        panels[0, 0].set_title("target")
        panels[0, 1].set_title("shape")
        figure.colorbar(drawn, ax=panels, label="distance from the target (mm)", shrink=0.7)
        return figure


def _fill(
    axes: Axes, surface: Surface, view: View, values: Array, largest: float
) -> PolyCollection:
    seen = view.project(MM_PER_M * (surface.corners - surface.centroid))
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    drawn = PolyCollection(
        list(seen[order][:, :, :2]), array=values[order], cmap="viridis", edgecolors="0.3",
        linewidths=0.15,
    )  # fmt: skip
    drawn.set_clim(0.0, largest)
    drawn.cmap.set_bad("0.85")
    axes.add_collection(drawn)
    return drawn


def draw_search(nominal: Sequence[float], worst: Sequence[float], best: Sequence[float]) -> Figure:
    """Draw the distance from the target over the evaluations of a search.

    Parameters
    ----------
    nominal, worst : sequence of float
        Of the nominal specimen and the worst of its scenarios, m; NaN if there was no shape.
    best : sequence of float
        The nominal one of the best design so far, m.
    """
    count = np.arange(1, len(best) + 1)
    with print_style():
        figure = new_figure(5.0, 3.0)
        axes = figure.subplots()
        axes.plot(count, MM_PER_M * np.array(best), color=RESULT_COLOURS[0], label="best so far")
        axes.plot(count, MM_PER_M * np.array(nominal), "o", color=RESULT_COLOURS[0], ms=3,
                  label="nominal")  # fmt: skip
        if np.any(np.array(worst) != np.array(nominal)):
            axes.plot(count, MM_PER_M * np.array(worst), "^", color=RESULT_COLOURS[1], ms=3,
                      label="worst of the errors")  # fmt: skip
        axes.set(xlabel="evaluation", ylabel="distance from the target (mm)", yscale="log")
        axes.legend()
        return figure
