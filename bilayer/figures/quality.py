"""Quality against prestretch, of one solver against another, and what a comparison found."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.figures.caveat_marks import mark_caveats
from bilayer.figures.style import (
    RESULT_COLOURS,
    RESULT_MARKERS,
    label_text,
    new_figure,
    print_style,
)
from bilayer.results.caveats import is_unstable, touches_itself
from bilayer.results.comparison import compare, result_label
from bilayer.results.milestones import along_milestones
from bilayer.results.released_shapes import MM_PER_M

QUALITY_LABEL = "quality (0 hemisphere, 1 flat)"
PRESTRETCH_LABEL = "prestretch λ"


def draw_quality(results: Sequence[xr.Dataset]) -> Figure:
    """Draw quality against prestretch.

    Parameters
    ----------
    results : sequence of Dataset
        Any number of results; milestones that were not reached are crosses above the frame,
        unstable ones and those that touch themselves are ringed.
    """
    with print_style():
        figure = new_figure(4.8, 3.8)
        axes = figure.add_subplot()
        for k, result in enumerate(_each("results", results)):
            stretch, quality = result["prestretch"].values, result["quality"].values
            _draw_line(axes, stretch, quality, k, label_text(result_label(result)))
            mark_caveats(axes, stretch, quality, is_unstable(result), touches_itself(result))
        _label_quality(axes)
        figure.legend(loc="outside upper center", ncols=2)
    return figure


def draw_quality_against(shell: xr.Dataset, reference: xr.Dataset) -> Figure:
    """Draw the quality of one result against that of another, as in the paper's figure 6.

    Parameters
    ----------
    shell, reference : Dataset
        Results on the same planar mesh; the first goes up, the second along.

    Raises
    ------
    InputError
        They cannot be compared, see `bilayer.results.comparison.compare`.
    """
    comparison = compare(reference, shell)
    along, up = comparison["quality"].values
    with print_style():
        figure = new_figure(4.2, 4.4)
        axes = figure.add_subplot()
        axes.plot([0, 1], [0, 1], color="0.5", linestyle="--", linewidth=0.9, label="equal quality")
        axes.plot(along, up, "o", color=RESULT_COLOURS[0], clip_on=False,
                  label="milestone, with its λ")  # fmt: skip
        mark_caveats(axes, along, up, *_against_either(comparison))
        for stretch, x, y in zip(comparison["prestretch"].values, along, up, strict=True):
            if np.isfinite(x + y):
                axes.annotate(f"{stretch:g}", (x, y), xytext=(5, -3), textcoords="offset points",
                              va="top", fontsize=8)  # fmt: skip
        axes.set(xlim=(0, 1), ylim=(0, 1), aspect="equal")
        axes.set_xlabel(f"quality of {label_text(comparison.attrs['first'])}")
        axes.set_ylabel(f"quality of {label_text(comparison.attrs['second'])}")
        axes.grid(True)
        figure.legend(loc="outside upper center", ncols=2)
    return figure


def draw_comparison(comparison: xr.Dataset) -> Figure:
    """Draw what `bilayer.results.comparison.compare` found: rms distance, quality and height."""
    comparison = along_milestones(comparison)
    labels = [label_text(comparison.attrs[side]) for side in ("first", "second")]
    stretch = comparison["prestretch"].values
    with print_style():
        figure = new_figure(7.2, 3.0)
        distance, quality, height = figure.subplots(1, 3, sharex=True)
        percent = 100 * comparison["rms_distance_over_radius"].values
        distance.plot(stretch, percent, "k.-")
        distance.set_ylabel("rms distance (% of R)")
        distance.margins(y=0.1)
        distance.set_ylim(bottom=0)
        _finish(distance)
        for k, label in enumerate(labels):
            of_one = comparison.isel(result=k)
            against = of_one["unstable"].values, of_one["touches_itself"].values
            _draw_line(quality, stretch, of_one["quality"].values, k, label)
            mark_caveats(quality, stretch, of_one["quality"].values, *against)
            height.plot(stretch, MM_PER_M * of_one["height"].values, **_line_style(k))
        _label_quality(quality)
        height.set_ylabel("height (mm)")
        height.set_ylim(bottom=0)
        _finish(height)
        handles, names = quality.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside upper center", ncols=len(names))
    return figure


def draw_distances(comparisons: Sequence[xr.Dataset]) -> Figure:
    """Draw how far several results are from one: rms distance against prestretch, logarithmic.

    Parameters
    ----------
    comparisons : sequence of Dataset
        From `bilayer.results.comparison.compare`, all with the same first result.
    """
    with print_style():
        figure = new_figure(4.8, 3.8)
        axes = figure.add_subplot()
        for k, comparison in enumerate(_each("comparisons", comparisons), start=1):
            percent = 100 * comparison["rms_distance_over_radius"].values
            label = label_text(comparison.attrs["second"])
            stretch = comparison["prestretch"].values
            axes.semilogy(stretch, percent, label=label, **_line_style(k))
            mark_caveats(axes, stretch, percent, *_against_either(comparison))
        axes.set_ylabel(f"rms distance to {label_text(comparisons[0].attrs['first'])} (% of R)")
        _finish(axes)
        figure.legend(loc="outside upper center", ncols=len(comparisons))
    return figure


def _each(name: str, datasets: Sequence[xr.Dataset]) -> list[xr.Dataset]:
    """Return each of several datasets with its milestones along a dimension."""
    if isinstance(datasets, xr.Dataset):
        raise InputError(f"{name} = a dataset: expected a list of them")
    return [along_milestones(dataset) for dataset in datasets]


def _against_either(comparison: xr.Dataset) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Whether either result is unstable, and whether either touches itself, per milestone."""
    unstable, touching = (
        comparison[name].any("result").values for name in ("unstable", "touches_itself")
    )
    return unstable, touching


def _draw_line(
    axes: Axes, stretch: NDArray[np.float64], quality: NDArray[np.float64], k: int, label: str
) -> None:
    """Draw one result, and a cross above the frame if a milestone was not reached."""
    axes.plot(stretch, quality, label=label, clip_on=False, **_line_style(k))
    missing = stretch[np.isnan(quality)]
    if len(missing):
        axes.plot(missing, np.full(len(missing), 1.03 + 0.05 * k), linestyle="none", marker="x",
                  markersize=6, markeredgewidth=1.6, color=_line_style(k)["color"], clip_on=False,
                  transform=axes.get_xaxis_transform(),
                  label=f"{label}, not reached")  # fmt: skip


def _line_style(k: int) -> dict[str, Any]:
    return {
        "color": RESULT_COLOURS[k % len(RESULT_COLOURS)],
        "marker": RESULT_MARKERS[k % len(RESULT_MARKERS)],
    }


def _label_quality(axes: Axes) -> None:
    axes.set_ylim(0, 1)
    axes.set_ylabel(QUALITY_LABEL)
    _finish(axes)


def _finish(axes: Axes) -> None:
    axes.set_xlabel(PRESTRETCH_LABEL)
    axes.grid(True)
