"""Results as plain records of numbers in SI units, which `--json` prints."""

from typing import Any

import numpy as np
import xarray as xr

from bilayer.results.caveats import is_unstable, touches_itself
from bilayer.results.milestones import along_milestones
from bilayer.results.report import trust_sentences
from bilayer.results.schema import result_specimen
from bilayer.specimen.toml_text import parse_toml


def result_record(result: xr.Dataset) -> dict[str, Any]:
    """Return a result without its fields: what made it, its milestones, what is against it.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.

    Returns
    -------
    dict
        `solver`, `model`, `specimen` (its name), `mesh`, `settings`, `versions`, `git_commit`,
        `stop_reason`, `units` by the name of a number, `milestones` (a list of numbers by name),
        `trust` (sentences).
    """
    result = along_milestones(result)
    judged = result.assign(
        unstable=("prestretch", is_unstable(result)),
        touches_itself=("prestretch", touches_itself(result)),
    )
    return {
        "solver": result.attrs["solver"],
        "model": result.attrs["model"],
        "specimen": result_specimen(result).name,
        "mesh": {"nodes": result.sizes["node"], "triangles": result.sizes["face"]},
        "settings": parse_toml(result.attrs["settings"], "settings of the result"),
        "versions": result.attrs["versions"],
        "git_commit": result.attrs["git_commit"],
        "stop_reason": result.attrs["stop_reason"],
        "units": _units(judged),
        "milestones": _milestones(judged),
        "trust": trust_sentences(result),
    }


def comparison_record(comparison: xr.Dataset) -> dict[str, Any]:
    """Return what `bilayer.results.comparison.compare` found.

    Returns
    -------
    dict
        `first` and `second` (labels), `units`, `milestones`: each with its distances and, under
        `first` and `second`, the numbers of either result.
    """
    comparison = along_milestones(comparison)
    shared = comparison.drop_dims("result")
    sides = {
        side: _milestones(comparison.isel(result=k)[_of_each(comparison)])
        for k, side in enumerate(("first", "second"))
    }
    return {
        "first": comparison.attrs["first"],
        "second": comparison.attrs["second"],
        "units": _units(comparison),
        "milestones": [
            {**row, **{side: rows[k] for side, rows in sides.items()}}
            for k, row in enumerate(_milestones(shared))
        ],
    }


def _of_each(comparison: xr.Dataset) -> list[str]:
    return [str(name) for name, v in comparison.data_vars.items() if "result" in v.dims]


def _units(dataset: xr.Dataset) -> dict[str, str]:
    """Return the units of the numbers that `_milestones` gives; none of those without."""
    named = {str(name): dataset[name].attrs.get("units", "1") for name in _numbers(dataset)}
    return {name: unit for name, unit in named.items() if unit != "1"}


def _milestones(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the numbers of each milestone by name: one, or one for each axis or energy term."""
    columns = {name: _column(dataset, name) for name in _numbers(dataset)}
    return [
        {name: column[k] for name, column in columns.items()}
        for k in range(dataset.sizes["prestretch"])
    ]


def _numbers(dataset: xr.Dataset) -> list[str]:
    """Return the variables that hold a number, or a few, for each milestone."""
    small = {"prestretch", "xyz", "term", "result"}
    return [
        str(name)
        for name, variable in dataset.variables.items()
        if "prestretch" in variable.dims and set(variable.dims) <= small
        and variable.dtype.kind in "fiub"
    ]  # fmt: skip


def _column(dataset: xr.Dataset, name: str) -> list[Any]:
    variable = dataset[name]
    along = [dim for dim in variable.dims if dim != "prestretch"]
    values = variable.transpose("prestretch", *along).values
    if along == ["term"]:
        terms = [str(term) for term in dataset["term"].values]
        return [dict(zip(terms, row, strict=True)) for row in values.tolist()]
    return list(np.asarray(values).tolist())
