"""Quality against prestretch, of one solver against another, and what a comparison found."""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.figures.branch_changes import branch_changes, line_with_gaps
from bilayer.figures.caveat_marks import mark_caveats
from bilayer.figures.result_looks import Look, result_looks, result_name
from bilayer.figures.style import axes_for, legend_for, new_figure, print_style
from bilayer.results.caveats import is_unstable, touches_itself
from bilayer.results.comparison import compare, result_label
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M

QUALITY_LABEL = "quality (0 hemisphere, 1 flat)"
PRESTRETCH_LABEL = "prestretch λ"


def draw_quality(results: Sequence[xr.Dataset], ax: Axes | None = None) -> Figure:
    """Draw quality against prestretch.

    Parameters
    ----------
    results : sequence of Dataset
        Any number of results; milestones that were not reached are crosses above the frame,
        unstable ones and those that touch themselves are ringed. A line has a gap where the shapes
        change to another branch.
    ax : Axes, optional
        Where to draw; a new figure if left out.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> figure = bilayer.draw_quality([result])
    """
    with print_style():
        figure, axes = axes_for(ax, 4.8, 3.8)
        shown = _each("results", results)
        looks = result_looks([result_label(result) for result in shown])
        for k, (result, look) in enumerate(zip(shown, looks, strict=True)):
            stretch, quality = result["prestretch"].values, result["quality"].values
            changes = branch_changes(stretch, _describing(result))
            _draw_line(axes, stretch, quality, k, look, changes)
            mark_caveats(axes, stretch, quality, is_unstable(result), touches_itself(result))
        _label_quality(axes)
        legend_for(figure, ax, axes, 2)
    return figure


def draw_quality_against(
    shell: xr.Dataset, reference: xr.Dataset, ax: Axes | None = None
) -> Figure:
    """Draw the quality of one result against that of another, as in the paper's figure 6.

    Parameters
    ----------
    shell, reference : Dataset
        Results on the same planar mesh; the first goes up, the second along.
    ax : Axes, optional
        Where to draw; a new figure if left out.

    Raises
    ------
    InputError
        They cannot be compared, see `bilayer.results.comparison.compare`.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> hinge = bilayer.solve(specimen, "dshell", bilayer.HingeSettings())
    >>> figure = bilayer.draw_quality_against(hinge, result)
    """
    comparison = compare(reference, shell)
    along, up = comparison["quality"].values
    reference_look, look = result_looks([comparison.attrs["first"], comparison.attrs["second"]])
    with print_style():
        figure, axes = axes_for(ax, 4.2, 4.4)
        axes.plot([0, 1], [0, 1], color="0.5", linestyle="--", linewidth=0.9, label="equal quality")
        axes.plot(along, up, look.marker, color=look.colour, clip_on=False,
                  label="milestone, with its λ")  # fmt: skip
        mark_caveats(axes, along, up, *_against_either(comparison))
        for stretch, x, y in zip(comparison["prestretch"].values, along, up, strict=True):
            if np.isfinite(x + y):
                axes.annotate(f"{stretch:g}", (x, y), xytext=(5, -3), textcoords="offset points",
                              va="top", fontsize=8)  # fmt: skip
        axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
        axes.set_xlabel(f"quality, {reference_look.name}")
        axes.set_ylabel(f"quality, {look.name}")
        axes.grid(True)
        legend_for(figure, ax, axes, 2)
    return figure


def draw_comparison(comparison: xr.Dataset) -> Figure:
    """Draw what `bilayer.results.comparison.compare` found: rms distance, quality and height.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> hinge = bilayer.solve(specimen, "dshell", bilayer.HingeSettings())
    >>> figure = bilayer.draw_comparison(bilayer.compare(result, hinge))
    """
    comparison = along_milestones(comparison)
    looks = result_looks([comparison.attrs[side] for side in ("first", "second")])
    stretch = comparison["prestretch"].values
    with print_style():
        figure = new_figure(7.2, 3.0)
        distance, quality, height = figure.subplots(1, 3, sharex=True)
        percent = 100 * comparison["rms_distance_over_radius"].values
        distance.plot(stretch, percent, "k.-")
        distance.set_ylabel("rms distance (% of the sheet's radius)")
        _finish(distance)
        _from_zero(distance)
        for k, look in enumerate(looks):
            of_one = comparison.isel(result=k)
            against = of_one["unstable"].values, of_one["touches_itself"].values
            changes = branch_changes(stretch, _describing(of_one))
            _draw_line(quality, stretch, of_one["quality"].values, k, look, changes)
            mark_caveats(quality, stretch, of_one["quality"].values, *against)
            shown = line_with_gaps(stretch, MM_PER_M * of_one["height"].values, changes)
            height.plot(*shown, **look.style)
        _label_quality(quality)
        height.set_ylabel("height (mm)")
        _finish(height)
        _from_zero(height)
        handles, names = quality.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    return figure


def draw_distances(comparisons: Sequence[xr.Dataset], ax: Axes | None = None) -> Figure:
    """Draw how far several results are from one: rms distance against prestretch, logarithmic.

    Parameters
    ----------
    comparisons : sequence of Dataset
        From `bilayer.results.comparison.compare`, all with the same first result.
    ax : Axes, optional
        Where to draw; a new figure if left out.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> hinge = bilayer.solve(specimen, "dshell", bilayer.HingeSettings())
    >>> figure = bilayer.draw_distances([bilayer.compare(result, hinge)])
    """
    with print_style():
        figure, axes = axes_for(ax, 4.8, 3.8)
        shown = _each("comparisons", comparisons)
        looks = result_looks([comparison.attrs["second"] for comparison in shown])
        for comparison, look in zip(shown, looks, strict=True):
            percent = 100 * comparison["rms_distance_over_radius"].values
            stretch = comparison["prestretch"].values
            axes.semilogy(stretch, percent, label=look.name, **look.style)
            mark_caveats(axes, stretch, percent, *_against_either(comparison))
        reference = result_name(comparisons[0].attrs["first"])
        axes.set_ylabel(f"rms distance to {reference} (% of the sheet's radius)")
        _finish(axes)
        legend_for(figure, ax, axes, len(shown))
    return figure


def _each(name: str, datasets: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return each of several datasets with its milestones along a dimension."""
    if isinstance(datasets, xr.Dataset):
        raise InputError(f"{name} = a dataset: expected a list of them")
    return [along_milestones(dataset) for dataset in datasets]


def _describing(result: xr.Dataset) -> NDArray[np.float64]:
    """Return numbers of the order of one that describe each shape, (milestones, 4)."""
    spans = result["span"].values
    return np.column_stack([spans / np.nanmax(spans), result["hemisphere_distance"].values])


def _against_either(comparison: xr.Dataset) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether either result is unstable, and whether either touches itself, per milestone."""
    unstable, touching = (
        comparison[name].any("result").values for name in ("unstable", "touches_itself")
    )
    return unstable, touching


def _draw_line(
    axes: Axes,
    stretch: NDArray[np.float64],
    quality: NDArray[np.float64],
    k: int,
    look: Look,
    changes: NDArray[np.bool_],
) -> None:
    """Draw one result, and a cross above the frame if a milestone was not reached."""
    shown = line_with_gaps(stretch, quality, changes)
    axes.plot(*shown, label=look.name, clip_on=False, **look.style)
    missing = stretch[np.isnan(quality)]
    if len(missing):
        axes.plot(missing, np.full(len(missing), 1.03 + 0.05 * k), linestyle="none", marker="x",
                  markersize=6, markeredgewidth=1.6, color=look.colour, clip_on=False,
                  transform=axes.get_xaxis_transform(),
                  label=f"{look.name}, not reached")  # fmt: skip


def _label_quality(axes: Axes) -> None:
    axes.set_ylim(0, 1)
    axes.set_ylabel(QUALITY_LABEL)
    _finish(axes)


def _from_zero(axes: Axes) -> None:
    """Let the vertical axis begin at zero and end above the highest point."""
    axes.margins(y=0.1)
    axes.autoscale_view()
    axes.set_ylim(bottom=0)


def _finish(axes: Axes) -> None:
    axes.set_xlabel(PRESTRETCH_LABEL)
    axes.grid(True)
