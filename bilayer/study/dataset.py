"""A study as one dataset: the scalars of all cases, and their shapes if they share a mesh.

Values are read from the case files when they are asked for (dask), not before.
"""

import json
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError
from bilayer.results.conformity import LAYOUTS
from bilayer.results.files import RESULT_FILE, open_result
from bilayer.results.netcdf import StoredGroup, read_netcdf
from bilayer.study.folder import StudyFolder
from bilayer.study.milestones import MilestoneAxis
from bilayer.study.scalars import Scalars, read_scalars

MESH_VARIABLES = ("reference_position", "face_nodes", "region")
Entry = Mapping[str, Any]
"""A case of the folder's plan, see `StudyFolder.keep_plan`."""


def open_study(path: str | Path) -> xr.Dataset:
    """Open all results of a study as one lazily loaded dataset.

    Parameters
    ----------
    path : path-like
        The study's folder.

    Returns
    -------
    Dataset
        Each scalar of the results, in SI units, over the varied fields and `prestretch`: the
        fields are dimensions if the cases are the product of their values, else coordinates of
        the dimension `case`. Along `prestretch` lie `prestretch_x` and `prestretch_y`; a value
        stands there again for another pair, or if a load path comes back to it (`visit`). What is
        not computed, or not reached, is NaN. Coordinates `solver`, `model`, `identity` and
        `case_file` (empty if there is none) tell the case; if all cases share one planar
        mesh, `position` and the mesh are there, too.

    Raises
    ------
    InputError
        There is no study in the folder.
    ComputationError
        The package dask is missing.

    Examples
    --------
    >>> import bilayer
    >>> study = bilayer.open_study("study")  # doctest: +SKIP
    >>> study["quality"].sel({"cut.strips": 5, "prestretch": 1.15})  # doctest: +SKIP
    """
    folder = StudyFolder(path)
    planned = folder.read_plan()
    entries, fields = planned["cases"], planned["fields"]
    axis = MilestoneAxis.of([entry["milestones"] for entry in entries])
    files = [folder.kept_file(entry["case"]) for entry in entries]
    found = [file.exists() for file in files]
    present = [file if there else None for file, there in zip(files, found, strict=True)]
    study = xr.Dataset(
        _scalar_variables(entries, present, axis),
        coords={
            **axis.coordinates(),
            "identity": ("case", [entry["case"] for entry in entries]),
            "solver": ("case", [entry["solver"] for entry in entries]),
            "model": ("case", [entry["model"] for entry in entries]),
            "case_file": ("case", ["" if file is None else str(file) for file in present]),
        },
        attrs={"study": str(path), "fields": list(fields)},
    )
    if any(found) and len({entry["mesh"] for entry in entries}) == 1:
        study = study.assign(_shape_variables(entries, present, axis))
    return _along_fields(study, entries, fields)


def _dask() -> Any:
    """Return dask, loaded here for the sake of all who open no study: it takes 0.2 s."""
    try:
        import dask.array
    except ImportError as error:
        raise ComputationError(
            f"a study cannot be opened: {error}; expected the package dask (pip install dask)"
        ) from error
    return dask


def _scalar_variables(
    entries: Sequence[Entry], files: Sequence[Path | None], axis: MilestoneAxis
) -> dict[str, Any]:
    """Return each scalar over (case, prestretch), its values still in the files."""
    dask = _dask()
    kinds = _examples(entries, files)
    held = dict.fromkeys(name for kind in kinds for name in kind.values)
    names = [name for name in held if name not in axis.coordinates()]
    read = [
        None
        if file is None
        else dask.delayed(_read_milestones)(
            file, names, axis.places(entry["milestones"]), len(axis)
        )
        for entry, file in zip(entries, files, strict=True)
    ]
    variables = {}
    for name in names:
        example = next(kind for kind in kinds if name in kind.values)
        shape = (len(axis), *example.values[name].shape[1:])
        rows = [
            dask.array.full(shape, np.nan)
            if table is None
            else dask.array.from_delayed(table[name], shape, dtype=float)
            for table in read
        ]
        dims = ("case", "prestretch", "xyz")[: len(shape) + 1]
        variables[name] = (dims, dask.array.stack(rows), example.variable_attributes[name])
    return variables


def _examples(entries: Sequence[Entry], files: Sequence[Path | None]) -> list[Scalars]:
    """Return the scalars of the first file of each model: which variables there are."""
    first: dict[tuple[str, str], Path] = {}
    for entry, file in zip(entries, files, strict=True):
        if file is not None:
            first.setdefault((entry["solver"], entry["model"]), file)
    return [read_scalars(file) for file in first.values()]


def _read_milestones(
    file: Path, names: Sequence[str], places: NDArray[np.int64], length: int
) -> dict[str, NDArray[np.float64]]:
    """Read one file's scalars at their places among all milestones; NaN elsewhere."""
    stored = read_scalars(file)
    stored.check_milestones(file, len(places))
    values = stored.values
    shapes = {name: array.shape[1:] for name, array in values.items()}
    table = {name: np.full((length, *shapes.get(name, ())), np.nan) for name in names}
    for name in values.keys() & table.keys():
        table[name][places] = values[name]
    return table


def _shape_variables(
    entries: Sequence[Entry], files: Sequence[Path | None], axis: MilestoneAxis
) -> dict[str, Any]:
    """Return the positions of cases on one mesh, still in the files, and that mesh."""
    dask = _dask()
    example = open_result(next(file for file in files if file is not None))
    mesh, attributes = example[list(MESH_VARIABLES)], example["position"].attrs
    shape = (len(axis), *mesh["reference_position"].shape)
    rows = [
        dask.array.full(shape, np.nan)
        if file is None
        else dask.array.from_delayed(
            dask.delayed(_read_position)(file, axis.places(entry["milestones"]), shape),
            shape,
            dtype=float,
        )
        for entry, file in zip(entries, files, strict=True)
    ]
    dims = ("case", "prestretch", "node", "xyz")
    variables: dict[Any, Any] = dict(mesh.data_vars.items())
    return {**variables, "position": (dims, dask.array.stack(rows), attributes)}


def _read_position(
    file: Path, places: NDArray[np.int64], shape: tuple[int, ...]
) -> NDArray[np.float64]:
    table = np.full(shape, np.nan)
    dims = [LAYOUTS["position"].dims]
    stored = read_netcdf(file, RESULT_FILE, partial(StoredGroup.of, dims=dims)).variables
    found = stored["position"][1] if "position" in stored else np.zeros(0)
    expected = (len(places), *shape[1:])
    if found.shape != expected or found.dtype.kind != "f":
        raise InputError(
            f"{RESULT_FILE} {file}: position has {found.dtype} of the shape {found.shape}, "
            f"expected numbers of the shape {expected}, as the study's plan has it"
        )
    table[places] = found
    return table


def _along_fields(study: xr.Dataset, entries: Sequence[Entry], fields: Sequence[str]) -> xr.Dataset:
    """Turn the dimension `case` into the varied fields if the cases are their product."""
    values = {
        name: [entry["solver"] if name == "solver" else entry["values"].get(name)
               for entry in entries]
        for name in fields
    }  # fmt: skip
    columns = {name: ("case", _column(column)) for name, column in values.items()}
    by_field = study.assign_coords(columns)
    if not fields or not _is_product(values):
        return by_field
    if len(fields) == 1:  # a single index, which has no levels to unstack
        return by_field.swap_dims(case=fields[0]).sortby(fields[0])
    return by_field.set_index(case=list(fields)).unstack("case").transpose(*fields, ...)


def _is_product(values: Mapping[str, list[Any]]) -> bool:
    """Whether the cases are every combination of the fields' values, each once."""
    rows = {json.dumps(row) for row in zip(*values.values(), strict=True)}
    plain = all(isinstance(v, (str, int, float)) for column in values.values() for v in column)
    count = len(next(iter(values.values())))
    sizes = [len({json.dumps(value) for value in column}) for column in values.values()]
    return plain and len(rows) == count == np.prod(sizes)


def _column(column: list[Any]) -> Any:
    """Return values as a column: numbers with NaN for none, anything else as text."""
    if all(isinstance(value, int) for value in column):
        return np.array(column)
    if all(value is None or isinstance(value, (int, float)) for value in column):
        return np.array(column, dtype=float)
    return ["" if value is None else str(value) for value in column]
