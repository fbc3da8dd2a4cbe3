"""The planar mesh, its edges coloured by the layers there, as in the paper's figure 1."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bilayer.figures.regions import region_colours, region_name, regions_of
from bilayer.figures.style import new_figure, print_style
from bilayer.geometry.surface import directed_edges
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.released_shapes import MM_PER_M

BILAYER_EDGE, BARE_EDGE = "black", "#D5202A"


def draw_mesh(mesh: PlanarMesh) -> Figure:
    """Draw a planar mesh, mm.

    Parameters
    ----------
    mesh : PlanarMesh
        Edges are black beside a triangle where all layers lie, red where a single one does on
        either side; in other colours where there are regions between.

    Examples
    --------
    >>> import bilayer
    >>> figure = bilayer.draw_mesh(bilayer.generate_mesh(bilayer.paper_specimen()))
    """
    with print_style():
        figure = new_figure(4.6, 4.7)
        axes = figure.add_subplot()
        region = edge_regions(mesh)
        colours = region_colours(mesh, BILAYER_EDGE, BARE_EDGE)
        for number in regions_of(mesh)[::-1]:
            name = region_name(mesh, number)
            _draw_edges(axes, mesh, region == number, colours[number], name)
        axes.set_aspect("equal")
        axes.margins(0.03)
        axes.autoscale_view()
        axes.set_xlabel("x (mm)")
        axes.set_ylabel("y (mm)")
        legend = figure.legend(loc="outside upper center", ncols=2, handlelength=1.6)
        for line in legend.get_lines():
            line.set_linewidth(1.5)
    return figure


def edge_regions(mesh: PlanarMesh) -> NDArray[np.int64]:
    """Return the region that each of `mesh.edges` counts for, that of the most layers, (e,)."""
    count, found = len(mesh.points), np.full(len(mesh.edges), -1)
    keys = _keys(mesh.edges, count)
    for region in regions_of(mesh):
        sides = directed_edges(mesh.triangles[mesh.region == region])
        beside = np.isin(keys, _keys(np.sort(sides, axis=1), count))
        found[beside & (found < 0)] = region
    return found


def _keys(edges: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    """One number per edge, from its two ascending nodes."""
    return edges[:, 0] * count + edges[:, 1]


def _draw_edges(
    axes: Axes, mesh: PlanarMesh, chosen: NDArray[np.bool_], colour: str, label: str
) -> None:
    if chosen.any():
        lines = MM_PER_M * mesh.points[mesh.edges[chosen]]
        width = min(0.8, 25 / np.sqrt(len(mesh.edges)))
        axes.add_collection(
            LineCollection(list(lines), colors=colour, linewidths=width, label=label)
        )
