"""The planar mesh with bilayer and bare edges in two colours, as in the paper's figure 1."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bilayer.figures.style import MILLIMETRES, new_figure, print_style
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.two_layers import KIRIGAMI

BILAYER_EDGE, BARE_EDGE = "black", "#D5202A"


def draw_mesh(mesh: PlanarMesh) -> Figure:
    """Draw a planar mesh, mm.

    Parameters
    ----------
    mesh : PlanarMesh
        Edges with a kirigami triangle on either side are black, the others, with the substrate
        alone on both, red.
    """
    with print_style():
        figure = new_figure(4.6, 4.7)
        axes = figure.add_subplot()
        bilayer = bilayer_edges(mesh)
        _draw_edges(axes, mesh, ~bilayer, BARE_EDGE, "bare substrate")
        _draw_edges(axes, mesh, bilayer, BILAYER_EDGE, "bilayer")
        axes.set_aspect("equal")
        axes.margins(0.03)
        axes.autoscale_view()
        axes.set_xlabel("x (mm)")
        axes.set_ylabel("y (mm)")
        legend = figure.legend(loc="outside upper center", ncols=2, handlelength=1.6)
        for line in legend.get_lines():
            line.set_linewidth(1.5)
    return figure


def bilayer_edges(mesh: PlanarMesh) -> NDArray[np.bool_]:
    """Return which of `mesh.edges` have a kirigami triangle on either side, shape (e,)."""
    covered = mesh.triangles[mesh.region == KIRIGAMI]
    sides = np.concatenate([covered[:, [0, 1]], covered[:, [1, 2]], covered[:, [2, 0]]])
    count = len(mesh.points)
    return np.isin(_keys(mesh.edges, count), _keys(np.sort(sides, axis=1), count))


def _keys(edges: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """One number per edge, from its two ascending nodes."""
    return edges[:, 0] * count + edges[:, 1]


def _draw_edges(
    axes: Axes, mesh: PlanarMesh, chosen: NDArray[np.bool_], colour: str, label: str
) -> None:
    if chosen.any():
        lines = MILLIMETRES * mesh.points[mesh.edges[chosen]]
        width = min(0.8, 25 / np.sqrt(len(mesh.edges)))
        axes.add_collection(
            LineCollection(list(lines), colors=colour, linewidths=width, label=label)
        )
