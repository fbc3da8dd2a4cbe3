"""A result computed again from what its own file holds, and whether the numbers agree.

Specimen, settings and planar mesh come from the file. A changed default or another version of gmsh
therefore makes no difference, with one exception: the coarse mesh from which a fine mesh of the
shell starts is generated again. On one machine two serial runs agree to the last bit. A run that
was started from another result uses the default start: the file does not hold that result.
"""

import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from bilayer.errors import INTERRUPTED, InputError
from bilayer.results.schema import TIMES_FOUND, result_mesh, result_specimen
from bilayer.results.starting import ANOTHER_RESULT, FLAT_START
from bilayer.results.table import stretches
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import settings_class, solve, solver_named
from bilayer.solvers.resuming import settings_of
from bilayer.specimen.settings import check_plain
from bilayer.specimen.toml_text import parse_toml

AGREEMENT = 1e-8
"""Largest difference of two positions that agree, relative to the outer radius."""
TIME_UNIT = "s"
"""Unit of the times in a result, which no two runs share."""


def select_reached_milestones(result: xr.Dataset) -> xr.Dataset:
    """Return a result that was interrupted without the milestones that it did not come to.

    Those of a failed computation stay: it is to fail again.
    """
    if result.attrs["stop_reason"] != INTERRUPTED:
        return result
    return result.isel(prestretch=result["converged"].values == 1)


def rerun(
    result: xr.Dataset,
    progress: Progress | None = None,
    output: str | Path | None = None,
    *,
    trust: bool = False,
) -> xr.Dataset:
    """Compute the milestones of a result again.

    Parameters
    ----------
    result : Dataset
        From `bilayer.open_result`.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    output : path-like, optional
        File of the new result, see `bilayer.solve`.
    trust : bool
        Allow settings that could run code or write files. They come from the result's file.

    Returns
    -------
    Dataset
        See `bilayer.results.schema`.

    Raises
    ------
    InputError
        No solver of ours made it, or its settings are unknown to this version, or not plain.
    """
    if TIMES_FOUND in result:
        raise InputError(
            "result: has the states of a search, expected one of `solve`; `bilayer states` with "
            "the same specimen and settings searches again"
        )
    settings = result_settings(result)
    if not trust:
        check_plain(settings)
    return solve(
        result_specimen(result).with_milestones([(x, y) for x, y in stretches(result)]),
        result.attrs["solver"],
        settings,
        mesh=result_mesh(result),
        start=FLAT_START if result.attrs.get("start") == FLAT_START else None,
        progress=progress,
        output=output,
    )


def result_settings(result: xr.Dataset) -> Any:
    """Return the settings of a result.

    Raises
    ------
    InputError
        No solver of ours made it, or its settings are unknown to this version.
    """
    kind: Any = settings_class(result.attrs["solver"], result.attrs["model"])
    return settings_of(result, kind)


def was_started_from_a_result(result: xr.Dataset) -> bool:
    """Whether a result was started from another one, of which it only keeps what it was."""
    return str(result.attrs.get("start", "")).startswith(ANOTHER_RESULT)


def solve_command(result: xr.Dataset, file: str) -> str:
    """Return the command that computes a result again from its specimen's file and its own mesh.

    Settings at their defaults, and the usual start, are left out.

    Parameters
    ----------
    result : Dataset
        From `bilayer.open_result`.
    file : str
        Where it is.

    Raises
    ------
    InputError
        No solver of ours made it.
    """
    solver, model = result.attrs["solver"], result.attrs["model"]
    defaults = vars(settings_class(solver, model)())
    words = ["bilayer", "solve", "again.toml", "--solver", solver, "--model", model]
    for name, value in parse_toml(result.attrs["settings"], "settings of the result").items():
        if value != defaults.get(name):
            words += ["--set", f"solver.{name}={_word(value)}"]
    if result.attrs.get("start") == FLAT_START != solver_named(solver).default_start:
        words += ["--start", FLAT_START]
    if was_started_from_a_result(result):
        words += ["--start", "START.nc"]
    return shlex.join([*words, "--mesh", file, "-o", "again.nc"])


def differences(first: xr.Dataset, second: xr.Dataset) -> pd.DataFrame:
    """Return the differences of two runs of one case.

    Parameters
    ----------
    first, second : Dataset
        Results on the same mesh, with the same milestones.

    Returns
    -------
    DataFrame
        A row per variable that both have, the times left out: `difference`, the largest in the
        variable's own unit (infinite if only one of them has a number), and `same_bits`.
    """
    names = [
        str(name)
        for name in first.data_vars
        if name in second
        and first[name].dtype.kind in "fi"
        and first[name].attrs.get("units") != TIME_UNIT
    ]
    rows = [
        {
            "variable": name,
            "difference": _largest(first[name].values, second[name].values),
            "units": first[name].attrs.get("units", ""),
            "same_bits": np.array_equal(first[name].values, second[name].values, equal_nan=True),
        }
        for name in names
    ]
    return pd.DataFrame(rows)


def agree(first: xr.Dataset, second: xr.Dataset) -> bool:
    """Whether two runs of one case reached the same milestones with the same shapes.

    The positions of all nodes agree to `AGREEMENT` times the outer radius.
    """
    reached = np.array_equal(first["converged"].values, second["converged"].values)
    length = result_specimen(first).characteristic_length
    distance = _largest(first["position"].values, second["position"].values)
    return reached and bool(distance <= AGREEMENT * length)


def _word(value: Any) -> str:
    """Return a setting as the command line reads it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def _largest(first: np.ndarray, second: np.ndarray) -> float:
    if first.shape != second.shape:
        return np.inf
    one_is_missing = np.isnan(first) != np.isnan(second)
    if one_is_missing.any():
        return np.inf
    same = (first == second) | np.isnan(first)  # infinite gaps, too
    with np.errstate(invalid="ignore"):
        return float(np.max(np.where(same, 0.0, np.abs(first - second)), initial=0.0))
