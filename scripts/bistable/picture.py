"""The figure: heights of the bent states over the prestretch, a panel for each sheet."""

from collections.abc import Sequence

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from bistable.cases import CROSS, LOTUS, PUBLISHED
from bistable.rows import Point, Row

COLOURS = ("tab:blue", "tab:orange", "tab:green")


def draw(rows: Sequence[Row], points: Sequence[Point]) -> Figure:
    """Draw both mirror states of each sheet; dots are the searches, crosses the solid."""
    figure, panels = plt.subplots(1, 2, figsize=(8, 3.6), sharey=True, layout="constrained")
    for axes, sheet in zip(panels, (LOTUS, CROSS), strict=True):
        _draw_sheet(
            axes,
            [row for row in rows if row.sheet == sheet],
            [point for point in points if point.sheet == sheet],
        )
        axes.set_title(sheet)
        axes.set_xlabel("prestretch")
    panels[0].set_ylabel("height [mm], the mirror state below 0")
    panels[1].legend(fontsize="small", loc="center right")
    return figure


def _draw_sheet(axes: Axes, rows: Sequence[Row], points: Sequence[Point]) -> None:
    thickness = sorted({point.outer for point in points}, reverse=True)
    for colour, outer in zip(COLOURS, thickness, strict=False):
        path = [point for point in points if point.outer == outer]
        label = f"outer layers {1e3 * outer:g} mm"
        for side in (1, -1):
            heights = [side * 1e3 * point.height for point in path]
            axes.plot([p.prestretch for p in path], heights, color=colour,
                      label=label if side == 1 else None)  # fmt: skip
        _draw_points(axes, [row for row in rows if abs(row.outer / outer - 1) < 1e-9], colour)
    axes.axhline(0, color="0.8", linewidth=0.8, zorder=0)


def _draw_points(axes: Axes, rows: Sequence[Row], colour: str) -> None:
    for row in rows:
        sides = (1, -1) if row.pairs else (1,)
        for side in sides:
            axes.plot(row.prestretch, side * 1e3 * row.height, "o", color=colour, markersize=4)
            if row.prestretch == PUBLISHED:
                axes.plot(row.prestretch, side * 1e3 * row.solid_height, "x", color="k",
                          markersize=7)  # fmt: skip
