"""The released shapes, isometric and from above, as in the paper's figures 2 and 3.

Every panel shows one milestone in its body frame, the upper side of the sheet up, at the same
scale; a milestone that was not reached shows the last shape on the way to it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import TriMesh
from matplotlib.colors import Normalize, to_rgb
from matplotlib.figure import Figure, SubFigure
from matplotlib.patches import Patch
from matplotlib.ticker import MultipleLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.figures.regions import region_colours, region_name, regions_of
from bilayer.figures.result_looks import result_name
from bilayer.figures.style import axes_for, label_text, new_figure, print_style
from bilayer.geometry.surface import Surface
from bilayer.mechanics.selection import ScalarField
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.comparison import result_label
from bilayer.results.milestones import along_milestones, choose_milestones
from bilayer.results.released_shapes import Shape, released_shapes
from bilayer.results.schema import result_mesh
from bilayer.validation import finite, one_of

Array = NDArray[np.float64]

COLUMNS = 4
PANEL_WIDTH = 1.8
"""Inches."""
LIGHT = np.array([-0.45, 0.45, 0.77])
"""Direction to the light as (right, up, toward the eye): over the left shoulder of the reader."""
UNDERSIDE = 0.45
"""Share of white in the colours of the lower side of the sheet."""
CUT_OFF = 0.005
"""Share of the faces at either end of a field's scale that take the colour of the end."""
NO_VALUE = "#DDDDDD"
"""Of faces where a field has no number."""
TRIAD = 1 / 8
"""Length of the axes drawn in an oblique view, about, over the width of what is shown."""


@dataclass(frozen=True, eq=False)
class Paint:
    """The colour of each triangle, (m, 3) from 0 to 1; on the lower side so much paler."""

    colours: Array
    paler: float = UNDERSIDE


@dataclass(frozen=True)
class View:
    """A parallel projection, from the azimuth and elevation of the eye, rad."""

    azimuth: float
    elevation: float

    def project(self, points: Array) -> Array:
        """Return points (..., 3) as (right, up, toward the eye)."""
        ca, sa = math.cos(self.azimuth), math.sin(self.azimuth)
        ce, se = math.cos(self.elevation), math.sin(self.elevation)
        right, up = np.array([-sa, ca, 0.0]), np.array([-se * ca, -se * sa, ce])
        return points @ np.array([right, up, [ce * ca, ce * sa, se]]).T


ISOMETRIC = View(-math.pi / 4, math.asin(1 / math.sqrt(3)))
BIRDS_EYE = View(-math.pi / 2, math.pi / 2)
FRONT = View(-math.pi / 2, 0.0)
VIEWS = {"isometric": ISOMETRIC, "above": BIRDS_EYE, "front": FRONT}
"""By name: from between x and -y, from above (x to the right, y up), along y."""


def draw_isometric(result: xr.Dataset) -> Figure:
    """Draw an isometric view of every milestone; see `draw_shapes`.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> figure = bilayer.draw_isometric(result)
    """
    return _draw_views(result, [ISOMETRIC])


def draw_birds_eye(result: xr.Dataset) -> Figure:
    """Draw every milestone as seen from above; see `draw_shapes`.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> figure = bilayer.draw_birds_eye(result)
    """
    return _draw_views(result, [BIRDS_EYE])


def draw_shapes(
    result: xr.Dataset,
    *,
    views: Sequence[str | tuple[float, float]] = ("isometric", "above"),
    milestones: Sequence[float] | None = None,
    field: ScalarField | None = None,
) -> Figure:
    """Draw the milestones of a result in some views, one view below the other.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    views : sequence
        Each "isometric", "above", "front", or azimuth and elevation of the eye in degrees: (0, 0)
        looks along -x, (-90, 0) along y.
    milestones : sequence of float, optional
        Prestretches of those that are drawn; all if left out.
    field : ScalarField, optional
        Colours the faces, with one scale for all shapes; without it, the layers do. It has a row
        for each milestone of the result, see `bilayer.mechanics.selection.scalar_field`.

    Raises
    ------
    InputError
        The result holds no shape, or has no such milestone.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> figure = bilayer.draw_shapes(result)
    """
    return _draw_views(result, [view_of(view) for view in views], milestones, field)


def draw_shape(
    result: xr.Dataset, milestone: float, view: str | tuple[float, float] = "isometric",
    ax: Axes | None = None,
) -> Figure:  # fmt: skip
    """Draw one milestone.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    milestone : float
        Its prestretch.
    view : str or (float, float)
        See `draw_shapes`.
    ax : Axes, optional
        Where to draw; a new figure if left out. Directions and a length are drawn beside the shape.

    Raises
    ------
    InputError
        The result has no such milestone, or no shape there.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> figure = bilayer.draw_shape(result, 1.03, view=(45.0, 20.0))
    """
    chosen = choose_milestones(along_milestones(result), [milestone])
    seen = view_of(view)
    mesh = result_mesh(chosen)
    shape = released_shapes(chosen, mesh)[0]
    with print_style():
        figure, axes = axes_for(ax, 3.0, 2.6)
        draw_frame(axes, shape, mesh, seen, frame_of(seen, [shape]))
    return figure


def draw_frame(axes: Axes, shape: Shape, mesh: PlanarMesh, view: View, frame: Array) -> None:
    """Draw one shape in axes that `frame_of` bounds, with directions and scale beside it."""
    _draw_shape(axes, shape, Paint(_face_colours(mesh)), view, frame)
    _draw_triad(np.array([[axes]]), view, frame)


def view_of(view: str | tuple[float, float]) -> View:
    """Return a view by its name, or by azimuth and elevation of the eye in degrees.

    Raises
    ------
    InputError
        There is none of the name.

    Examples
    --------
    >>> view_of((0, 90)).elevation == view_of("above").elevation
    True
    """
    if isinstance(view, str):
        return VIEWS[one_of("view", view, VIEWS)]
    if len(view) != 2:
        raise InputError(f"view = {view}: expected a name, or azimuth and elevation in degrees")
    azimuth, elevation = (finite("view", angle) for angle in view)
    return View(math.radians(azimuth), math.radians(elevation))


def _draw_views(
    result: xr.Dataset,
    views: Sequence[View],
    milestones: Sequence[float] | None = None,
    field: ScalarField | None = None,
) -> Figure:
    """Stack the views, each a grid of panels, under one legend."""
    result = along_milestones(result)
    result = result.assign_coords(row=("prestretch", np.arange(result.sizes["prestretch"])))
    if milestones is not None:
        result = choose_milestones(result, milestones)
    mesh = result_mesh(result)
    shapes = released_shapes(result, mesh)
    rows, columns = math.ceil(len(shapes) / COLUMNS), min(len(shapes), COLUMNS)
    frames = [frame_of(view, shapes) for view in views]
    heights = [rows * (PANEL_WIDTH * up / right + 0.25) + 0.25 for right, up in map(_size, frames)]
    top = 0.5 if field is None else 0.7  # a scale takes more room than the names of the layers
    with print_style():
        figure = new_figure(max(PANEL_WIDTH * columns + 0.4, 3.4), sum(heights) + top)
        legend, *parts = figure.subfigures(
            1 + len(views), 1, height_ratios=[top, *heights], squeeze=False
        )[:, 0]
        if field is None:
            _draw_legend(legend, result, mesh)
            paints = [Paint(_face_colours(mesh))] * len(shapes)
        else:
            rows_shown = result["row"].values[[shape.milestone for shape in shapes]]
            paints = _field_paints(legend, result, mesh, field, rows_shown)
        for view, frame, part in zip(views, frames, parts, strict=True):
            panels = part.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
            for axes, shape, paint in zip(panels.flat, shapes, paints, strict=False):
                _draw_shape(axes, shape, paint, view, frame)
            for axes in panels.flat[len(shapes) :]:
                axes.set_visible(False)
            if view is BIRDS_EYE:
                _label_axes(panels, len(shapes))
            else:
                _draw_triad(panels, view, frame)
    return figure


def frame_of(view: View, shapes: Sequence[Shape]) -> Array:
    """Return the lowest and highest (right, up) that hold every shape as seen, mm, (2, 2)."""
    seen = np.concatenate([view.project(shape.surface.points)[:, :2] for shape in shapes])
    margin = 0.03 * np.ptp(seen)
    width = np.ptp(seen[:, 0]) + 2 * margin
    room = 0.0 if view is BIRDS_EYE else 0.7 * round_length(TRIAD * width)  # below, for the triad
    return np.array([seen.min(axis=0) - [margin, margin + room], seen.max(axis=0) + margin])


def _size(frame: Array) -> Array:
    return frame[1] - frame[0]


def _draw_shape(axes: Axes, shape: Shape, paint: Paint, view: View, frame: Array) -> None:
    """Draw the triangles from the farthest to the nearest, each with a colour for each corner."""
    seen = view.project(shape.surface.corners)
    order = np.argsort(seen[:, :, 2].mean(axis=1))
    corners = seen[order, :, :2].reshape(-1, 2)
    triangles = np.arange(len(corners)).reshape(-1, 3)
    drawn = TriMesh(Triangulation(corners[:, 0], corners[:, 1], triangles), rasterized=True)
    shades: Any = _shaded(shape.surface, paint.colours, view, paint.paler)[order].reshape(-1, 3)
    drawn.set_facecolor(shades)
    axes.add_collection(drawn)
    axes.set(xlim=frame[:, 0], ylim=frame[:, 1], aspect="equal")
    ticks = round_length(_size(frame).max() / 4)
    axes.xaxis.set_major_locator(MultipleLocator(ticks))
    axes.yaxis.set_major_locator(MultipleLocator(ticks))
    axes.set_title(shape.title, pad=3)
    axes.annotate(
        shape.note, (0.98, 0.02), xycoords="axes fraction", ha="right", va="bottom", fontsize=7
    )


def round_length(about: float) -> float:
    """Return the nearest length of 1, 2 or 5 times a power of ten, by ratio.

    Examples
    --------
    >>> [round_length(about) for about in (10.6, 4.9, 8.0, 0.3)]
    [10.0, 5.0, 10.0, 0.2]
    """
    power = 10.0 ** math.floor(math.log10(about))
    return min((k * power for k in (1, 2, 5, 10)), key=lambda length: abs(math.log(length / about)))


def _label_axes(panels: NDArray[Any], shown: int) -> None:
    """Name the axes of a view along x and y, on the left and under the last panel of a column."""
    columns = panels.shape[1]
    for place, axes in enumerate(panels.flat[:shown]):
        if place % columns == 0:
            axes.set_ylabel("y (mm)")
        if place + columns >= shown:
            axes.set_xlabel("x (mm)")
            axes.tick_params(labelbottom=True)


def _draw_triad(panels: NDArray[Any], view: View, frame: Array) -> None:
    """Take the axes of an oblique view away; the first panel gets its directions and scale."""
    for axes in panels.flat:
        axes.set_axis_off()
    first = panels[0, 0]
    length = round_length(TRIAD * _size(frame)[0])
    corner = frame[0] + length * np.array([0.3, 0.6])
    for name, tip in zip("xyz", view.project(length * np.eye(3))[:, :2], strict=True):
        arrow = {"arrowstyle": "->", "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0}
        first.annotate("", corner + tip, xytext=corner, arrowprops=arrow)
        first.text(*(corner + 1.3 * tip), name, ha="center", va="center", fontsize=7)
    first.text(*(corner + length * np.array([1.3, -0.5])), f"axes: {length:g} mm", va="center",
               fontsize=7)  # fmt: skip


def _draw_legend(figure: SubFigure, result: xr.Dataset, mesh: PlanarMesh) -> None:
    colours = region_colours(mesh)
    patches = [
        Patch(color=colours[region], label=region_name(mesh, region)) for region in regions_of(mesh)
    ]
    columns = min(len(patches), 2) if len(patches) < 5 else 3
    title = result_name(result_label(result))
    figure.legend(handles=patches, loc="center", ncols=columns, title=title)


def _face_colours(mesh: PlanarMesh) -> Array:
    """Return the colour of each triangle by the layers there, (m, 3) from 0 to 1."""
    colours = region_colours(mesh)
    palette = [to_rgb(colours.get(number, "black")) for number in range(len(mesh.layer_sets))]
    return np.array(palette)[mesh.region]


def _field_paints(
    figure: SubFigure,
    result: xr.Dataset,
    mesh: PlanarMesh,
    field: ScalarField,
    rows: NDArray[np.int64],
) -> list[Paint]:
    """Draw the scale of a field; return the colours of some of its rows."""
    values = field.on_faces(mesh)[rows]
    known = values[np.isfinite(values)]
    if known.size == 0:
        raise InputError(f"field = {field.name!r}: has no number at any milestone")
    low, high = np.quantile(known, [CUT_OFF, 1 - CUT_OFF])
    both_signs = low < 0 < high
    if both_signs:
        low, high = -max(-low, high), max(-low, high)
    scale = ScalarMappable(Normalize(low, high), "RdBu_r" if both_signs else "viridis")
    figure.suptitle(result_name(result_label(result)), y=0.98, fontsize=8)
    bar = figure.add_axes((0.25, 0.55, 0.5, 0.13))
    figure.colorbar(scale, cax=bar, orientation="horizontal", extend="both")
    bar.set_xlabel(label_text(field.label), fontsize=8, labelpad=1)
    nowhere = np.array(to_rgb(NO_VALUE))
    return [
        Paint(
            np.where(np.isfinite(row)[:, None], scale.to_rgba(np.nan_to_num(row))[:, :3], nowhere),
            paler=0.0,
        )
        for row in values
    ]


def _shaded(surface: Surface, base: Array, view: View, paler: float = UNDERSIDE) -> Array:
    """Return the colour of each corner of each triangle, (m, 3, 3): triangle, corner, red to blue.

    The normal of a corner is that of the surface at its node, turned to the eye: the side that is
    seen is the one that is lit. The lower side of the sheet may be paler. Half Lambert shading
    keeps the parts away from the light apart, too.
    """
    own = view.project(surface.area_vectors / surface.areas[:, None])
    normals = view.project(_node_normals(surface))[surface.triangles]
    is_upper = own[:, 2] >= 0
    turned = normals * np.where(is_upper, 1.0, -1.0)[:, None, None]
    toward_light = turned @ (LIGHT / np.linalg.norm(LIGHT))
    shade = 0.35 + 0.65 * ((1 + toward_light) / 2) ** 1.5
    colours = np.where(is_upper[:, None], base, base + paler * (1 - base))
    return colours[:, None, :] * shade[:, :, None]


def _node_normals(surface: Surface) -> Array:
    """Return the unit normal of the surface at each node, from the triangles around it, (n, 3)."""
    summed = np.zeros_like(surface.points)
    np.add.at(summed, surface.triangles, surface.area_vectors[:, None, :])
    length = np.linalg.norm(summed, axis=1, keepdims=True)
    return summed / np.where(length > 0, length, 1.0)
