"""Results as text: the table of one run, and what made it."""

import tomllib

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.result import result_mesh, result_specimen
from bilayer.specimen import Layer


def result_table(result: xr.Dataset) -> str:
    """Return one line per milestone: shape, effort, stability."""
    millimetres = {"sphere_radius": "radius mm", "sphere_rmse": "rmse mm", "height": "height mm"}
    columns: dict[str, list[str]] = {"prestretch": [_pair(row) for row in _pairs(result)]}
    columns["converged"] = ["yes" if done else "no" for done in result["converged"].values]
    columns["quality"] = _formatted(result["quality"].values, "{:.3f}")
    for name, title in millimetres.items():
        columns[title] = _formatted(1e3 * result[name].values, "{:.2f}")
    for axis, title in enumerate(("span x mm", "span y mm")):
        columns[title] = _formatted(1e3 * result["span"].values[:, axis], "{:.2f}")
    columns["hemisphere"] = _formatted(result["hemisphere_distance"].values, "{:.3f}")
    columns["unstable"] = [
        str(count) if count >= 0 else "?" for count in result["unstable_modes"].values
    ]
    columns["steps"] = [str(count) for count in result["load_steps"].values]
    columns["iterations"] = [str(count) for count in result["iterations"].values]
    columns["residual"] = _formatted(result["residual"].values, "{:.1e}")
    columns["time s"] = _formatted(result["wall_time"].values, "{:.1f}")
    return pd.DataFrame(columns).to_string(index=False)


def provenance(result: xr.Dataset) -> str:
    """Return what made a result: solver, specimen, mesh, settings, versions, and its table."""
    specimen, mesh = result_specimen(result), result_mesh(result)
    done = int(result["converged"].sum())
    lines = [
        f"solver      {result.attrs['solver']}, model {result.attrs['model']}",
        f"specimen    {specimen.name}: radius {1e3 * specimen.outer_radius:g} mm, "
        + ("uncut" if specimen.cut is None else f"{specimen.cut.strips} strips"),
        f"substrate   {_layer(specimen.substrate)}",
        f"kirigami    {_layer(specimen.kirigami)}",
        f"mesh        {len(mesh.points)} nodes, {len(mesh.triangles)} triangles",
        "settings    " + ", ".join(f"{k} = {v!r}" for k, v in _settings(result).items()),
        f"versions    {result.attrs['versions']}",
        f"git commit  {result.attrs['git_commit'] or 'unknown'}",
        f"milestones  {done} of {result.sizes['prestretch']} reached",
    ]
    if result.attrs["stop_reason"]:
        lines.append(f"stopped     {result.attrs['stop_reason']}")
    return "\n".join([*lines, "", result_table(result), "", trust(result)])


def trust(result: xr.Dataset) -> str:
    """Return in one sentence how far the result can be trusted as an equilibrium."""
    done = result["converged"].values.astype(bool)
    if not done.any():
        return "No milestone was reached: there is no equilibrium in this file."
    modes = result["unstable_modes"].values[done]
    residual = result["residual"].values[done].max()
    solved = f"Every reached milestone is solved to a relative residual of {residual:.0e}"
    if (modes < 0).any():
        return f"{solved}; this method cannot tell whether it is stable."
    if (modes > 0).any():
        unstable = ", ".join(_pair(p) for p, m in zip(_pairs(result)[done], modes, strict=True) if m)
        return f"{solved}; NOT STABLE at {unstable}: another shape has less energy."
    return f"{solved}, and stable."


def _pairs(result: xr.Dataset) -> np.ndarray:
    return np.column_stack([result["prestretch_x"].values, result["prestretch_y"].values])


def _pair(pair: np.ndarray) -> str:
    return f"{pair[0]:g}" if pair[0] == pair[1] else f"{pair[0]:g},{pair[1]:g}"


def _formatted(values: np.ndarray, pattern: str) -> list[str]:
    return [pattern.format(value) if np.isfinite(value) else "-" for value in values]


def _settings(result: xr.Dataset) -> dict[str, object]:
    return tomllib.loads(result.attrs["settings"])


def _layer(layer: Layer) -> str:
    material = layer.material
    return (
        f"{1e3 * layer.thickness:g} mm, {type(material).__name__}, "
        f"E = {material.young_modulus:.6g} Pa, nu = {material.poisson_ratio:.4g}"
    )
