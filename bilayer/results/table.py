"""Numbers of a result as the cells of a table."""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from bilayer.specimen.load import FREE, Milestone
from bilayer.specimen.prestretch import stretch_of
from bilayer.specimen.specimen import Specimen


def stretches(result: xr.Dataset) -> NDArray[np.float64]:
    """Return (lambda_x, lambda_y) of each milestone, shape (milestones, 2)."""
    return np.column_stack([result["prestretch_x"].values, result["prestretch_y"].values])


def stretch_text(pair: NDArray[np.float64] | tuple[float, float]) -> str:
    """Return a prestretch as it is given on the command line: "1.06", or "1.06,1.05"."""
    return f"{pair[0]:g}" if pair[0] == pair[1] else f"{pair[0]:g},{pair[1]:g}"


def time_column(result: xr.Dataset) -> dict[tuple[str, str], list[str]]:
    """Return the column of a table with the times after the release; none if there are no times."""
    if "time" not in result.variables:
        return {}
    return {("after", "s"): cells(result["time"].values, "{:g}")}


def shape_title(milestone: xr.Dataset) -> str:
    """Return what a shape is called in a figure: "λ = 1.06", or "λ = 1.06, 10 s"."""
    (pair,) = stretches(milestone.expand_dims("prestretch"))
    title = f"λ = {stretch_text(pair)}"
    return f"{title}, {float(milestone['time']):g} s" if "time" in milestone.variables else title


def as_shown(values: NDArray[np.float64], unit: str) -> tuple[NDArray[np.float64], str]:
    """Return numbers of a load and their unit as tables and titles have them: lengths in mm."""
    return (1e3 * values, "mm") if unit == "m" else (values, unit)


def load_titles(result: xr.Dataset) -> list[str]:
    """Return the loads that differ between milestones, at each: ", tip -0.002 N", or ""."""
    titles = [""] * result.sizes["prestretch"]
    for name, load in result.coords.items():
        values = np.atleast_1d(load.values)
        if str(name).startswith("load_") and len(set(cells(values, "{:.17g}"))) > 1:
            numbers, unit = as_shown(values, load.attrs["units"])
            words = [FREE if np.isnan(v) else f"{v:.4g} {unit}" for v in numbers]
            title = f", {str(name).removeprefix('load_')} "
            titles = [f"{t}{title}{word}" for t, word in zip(titles, words, strict=True)]
    return titles


def milestone_text(specimen: Specimen, milestone: Milestone) -> str:
    """Return a milestone in a few words: "1.06, blow 120 Pa"."""
    return ", ".join([stretch_text(stretch_of(milestone)), *load_words(specimen, milestone)])


def load_words(specimen: Specimen, milestone: Milestone) -> list[str]:
    """Return the loads at a milestone, a few words each: "blow 120 Pa", "poke free"."""
    shown = [
        (load.name, *as_shown(np.array(value), load.unit))
        for load, value in zip(specimen.loads, milestone[2:], strict=True)
    ]
    return [
        f"{name} {FREE if np.isnan(number) else f'{number:.6g} {unit}'}"
        for name, number, unit in shown
    ]


def place_words(specimen: Specimen, milestone: Milestone) -> str:
    """Return a place on a load path in a few words: "prestretch 1.06, blow 120 Pa"."""
    larger = f"prestretch {max(stretch_of(milestone)):.6g}"
    return ", ".join([larger, *load_words(specimen, milestone)])


def cells(values: ArrayLike, pattern: str) -> list[str]:
    """Return each number in a format such as "{:.2f}", and "-" for NaN."""
    return [pattern.format(v) if np.isfinite(v) else "-" for v in np.asarray(values)]
