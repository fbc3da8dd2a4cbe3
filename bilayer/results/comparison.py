"""Two results of a specimen, milestone by milestone.

The rms distance is taken over the nodes of the reference surface, by their flat lumped areas, after
the rigid motion that makes it least. A second result on another planar mesh is taken at the nodes
of the first (`bilayer.results.other_mesh`). Everything else is each result's own measure, side by
side.
"""

from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.caveats import is_unstable, touches_itself
from bilayer.results.milestones import along_milestones
from bilayer.results.other_mesh import positions_on
from bilayer.results.schema import SAME_STRETCH, result_mesh, result_specimen
from bilayer.results.table import cells, stretch_text, stretches, time_column
from bilayer.runtime.terminal import one_line
from bilayer.specimen.layer import Layer
from bilayer.specimen.specimen import MeshSize, Specimen

MEASURES = (
    "quality",
    "hemisphere_distance",
    "sphere_radius",
    "sphere_rmse",
    "span",
    "height",
    "converged",
)


def result_label(result: xr.Dataset) -> str:
    """Return the solver and the model that made a result, as a name for it."""
    return f"{result.attrs['solver']} {result.attrs['model']}"


def compare(first: xr.Dataset, second: xr.Dataset) -> xr.Dataset:
    """Compare two results of the same specimen, best on the same planar mesh.

    Parameters
    ----------
    first, second : Dataset
        Results, see `bilayer.results.schema`.

    Returns
    -------
    Dataset
        Over the milestones that both have: `rms_distance` in m and `rms_distance_over_radius`,
        NaN if one of them was not reached, and, over the dimension `result`, the measures of
        each, with `unstable` and `touches_itself`. Attributes `first` and `second` are their
        labels; `meshes` says if their meshes differ.

    Raises
    ------
    InputError
        The specimens differ other than in name, mesh size and milestones, or no milestone is
        common.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> hinge = bilayer.solve(specimen, "dshell", bilayer.HingeSettings())
    >>> comparison = bilayer.compare(result, hinge)
    >>> bool(comparison["rms_distance_over_radius"] < 0.1)
    True
    """
    first, second = along_milestones(first), along_milestones(second)
    _check_same_specimen(result_specimen(first), result_specimen(second))
    mesh, other = result_mesh(first), result_mesh(second)
    here, there = _common_milestones(first, second)
    pair = [first.isel(prestretch=here), second.isel(prestretch=there)]
    shapes = [result["position"].values for result in pair]
    distance = _distances(mesh, shapes[0], positions_on(mesh, other, shapes[1]))
    measures = [_measures(result) for result in pair]
    compared = xr.concat(measures, dim="result", join="override").assign(
        rms_distance=("prestretch", distance, {"units": "m", "long_name": "rms distance"}),
        rms_distance_over_radius=(
            "prestretch",
            distance / result_specimen(first).characteristic_length,
            {
                "units": "1",
                "long_name": "rms distance over the flat sheet's radius",
            },
        ),
    )
    compared.attrs = {"first": result_label(first), "second": result_label(second)}
    if not mesh.same_as(other):
        compared.attrs["meshes"] = (
            f"meshes of {len(mesh.triangles)} and {len(other.triangles)} triangles: the second "
            "result is interpolated at the nodes of the first"
        )
    return compared


def _measures(result: xr.Dataset) -> xr.Dataset:
    against = {"unstable": is_unstable(result), "touches_itself": touches_itself(result)}
    return result[list(MEASURES)].assign({k: ("prestretch", v) for k, v in against.items()})


def comparison_table(comparison: xr.Dataset) -> str:
    """Return a comparison as text: a line per milestone, a and b side by side, units on top."""
    comparison = along_milestones(comparison)
    sides = (("a", comparison.isel(result=0)), ("b", comparison.isel(result=1)))
    percent = 100 * comparison["rms_distance_over_radius"]
    columns = {
        ("", "prestretch"): [stretch_text(pair) for pair in stretches(comparison)],
        **time_column(comparison),
        ("rms distance", "mm"): cells(1e3 * comparison["rms_distance"], "{:.3f}"),
        ("rms distance", "% of R"): cells(percent, "{:.2f}"),
    }
    for title, name, scale, pattern in (
        ("quality", "quality", 1.0, "{:.3f}"),
        ("hemisphere", "hemisphere_distance", 1.0, "{:.3f}"),
        ("radius mm", "sphere_radius", 1e3, "{:.2f}"),
        ("height mm", "height", 1e3, "{:.2f}"),
    ):
        for side, result in sides:
            columns[title, side] = cells(scale * result[name], pattern)
    for axis, title in enumerate(("span x mm", "span y mm")):
        for side, result in sides:
            columns[title, side] = cells(1e3 * result["span"].isel(xyz=axis), "{:.2f}")
    for title, name in (("unstable", "unstable"), ("contact", "touches_itself")):
        if comparison[name].any():
            for side, result in sides:
                reached = result["converged"].values
                columns[title, side] = [
                    ("yes" if found else "no") if there else "-"
                    for found, there in zip(result[name].values, reached, strict=True)
                ]
    heading = one_line(f"a: {comparison.attrs['first']}    b: {comparison.attrs['second']}")
    if "meshes" in comparison.attrs:
        heading += f"\n{one_line(comparison.attrs['meshes'])}"
    return f"{heading}\n{pd.DataFrame(columns).to_string(index=False)}"


def _check_same_specimen(first: Specimen, second: Specimen) -> None:
    """Raise InputError with the first field in which two specimens differ."""
    alike = [
        replace(specimen, name="", mesh=MeshSize()).with_milestones(first.prestretch.milestones)
        for specimen in (first, second)
    ]
    for field, mine, other in _differences("specimen", *alike):
        raise InputError(
            f"{field} = {mine} in the first result and {other} in the second: "
            "expected results of the same specimen"
        )


def _differences(field: str, mine: Any, other: Any) -> list[tuple[str, Any, Any]]:
    """Fields, by dotted name, in which two nested dataclasses differ, with their values."""
    if mine == other:
        return []
    parts, others = _parts(mine), _parts(other)
    if type(mine) is not type(other) or list(parts) != list(others) or not parts:
        return [(field, mine, other)]
    return [
        difference
        for name in parts
        for difference in _differences(f"{field}.{name}", parts[name], others[name])
    ]


def _parts(value: Any) -> dict[str, Any]:
    """Return the fields of a dataclass, or several layers, by name; nothing of a plain value."""
    if is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    if isinstance(value, tuple) and all(isinstance(part, Layer) for part in value):
        return {layer.name: layer for layer in value}
    return {}


def _common_milestones(
    first: xr.Dataset, second: xr.Dataset
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the places of the common milestones in either result.

    The first visit of a prestretch is compared with the first one of the other result, and so on.
    """
    mine, other = stretches(first), stretches(second)
    same = np.abs(mine[:, None] - other[None]).max(axis=2) < SAME_STRETCH
    same &= _visits(mine)[:, None] == _visits(other)[None]
    here, there = np.nonzero(same)
    if len(here) == 0:
        listed, others = (", ".join(stretch_text(p) for p in pairs) for pairs in (mine, other))
        raise InputError(
            f"prestretch.milestones = {listed} in the first result and {others} in the second: "
            "expected a common one"
        )
    return here, there


def _visits(pairs: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return the number of earlier visits to each milestone's prestretch, shape (n,)."""
    same = np.abs(pairs[:, None] - pairs[None]).max(axis=2) < SAME_STRETCH
    return np.tril(same, k=-1).sum(axis=1)


def _distances(
    mesh: PlanarMesh, first: NDArray[np.float64], second: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Rms distance at each milestone, m; NaN if a position is."""
    weights = flat_surface(mesh).node_areas
    known = np.isfinite(first + second).all(axis=(1, 2))
    distance = np.full(len(first), np.nan)
    distance[known] = [
        rms_distance(a, b, weights) for a, b in zip(first[known], second[known], strict=True)
    ]
    return distance
