"""Result files: NetCDF, whole or not there, and those of runs that are not finished.

The file of a run that is not finished has a group `resume` beside the dataset: all that its path
needs to go on from the last milestone. A finished one has none.
"""

import errno
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.results.schema import FORMAT, REQUIRED, SCHEMA_VERSION
from bilayer.runtime.output_file import HDF5_ROOM, whole_file

RESUME_GROUP = "resume"


@dataclass(frozen=True, eq=False)
class ResumePoint:
    """The point from which a run that is not finished can be resumed.

    Parameters
    ----------
    tried : int
        Milestones that are over, reached or given up.
    reasons : sequence of str
        Why some of them were not reached.
    saved : mapping of str to array
        From the last equilibrium's `save`.
    """

    tried: int
    reasons: tuple[str, ...]
    saved: Mapping[str, NDArray[Any]]


def write_result(result: xr.Dataset, path: str | Path, resume: ResumePoint | None = None) -> None:
    """Write a dataset as NetCDF, whole or not at all; a finished one is compressed.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    path : path-like
        The file.
    resume : ResumePoint, optional
        Where the run can be taken up; left out, the run is finished.

    Raises
    ------
    InputError
        The folder does not exist or cannot be written.
    ComputationError
        Writing failed, for example on a full disk; an earlier file of that name stays as it was.
    """
    packed: dict[Any, dict[str, Any]] = {
        name: {"zlib": True, "complevel": 4}
        for name, variable in result.variables.items()
        if variable.dtype.kind == "f" and variable.ndim > 1 and resume is None
    }
    without_gaps = {name: {"_FillValue": None} for name in result.coords}  # CF, section 2.5.1
    group = None if resume is None else _as_dataset(resume)
    room = result.nbytes + (0 if group is None else group.nbytes) + HDF5_ROOM
    with whole_file(path, "result file", room=room) as partial, _netcdf_errors(partial):
        result.to_netcdf(partial, engine="netcdf4", encoding=packed | without_gaps)
        if group is not None:
            group.to_netcdf(partial, engine="netcdf4", mode="a", group=RESUME_GROUP)


def open_result(path: str | Path) -> xr.Dataset:
    """Read a result into memory.

    Raises
    ------
    InputError
        The file is missing, is no dataset of this project, or has a newer schema.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            result = stored.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            f"result file {path}: cannot be read ({_why_unreadable(Path(path))})"
        ) from error
    if result.attrs.get("format") != FORMAT:
        raise InputError(
            f"result file {path}: format = {result.attrs.get('format')!r}, expected {FORMAT!r}"
        )
    _check_schema(path, result.attrs.get("schema_version"))
    for part, held in (("attribute", result.attrs), ("variable", result.variables)):
        missing = [name for name in REQUIRED[part] if name not in held]
        if missing:
            raise InputError(f"result file {path}: the {part} {missing[0]!r} is missing")
    return result


def open_resume_point(path: str | Path) -> ResumePoint | None:
    """Return the point from which the run of a file can be resumed; None if it is finished.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    try:
        with netCDF4.Dataset(path) as stored:
            if RESUME_GROUP not in stored.groups:
                return None
        with xr.open_dataset(path, engine="netcdf4", group=RESUME_GROUP) as stored_group:
            group = stored_group.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            f"result file {path}: cannot be read ({_why_unreadable(Path(path))})"
        ) from error
    reasons = np.atleast_1d(group.attrs["reasons"])
    return ResumePoint(
        int(group.attrs["tried"]),
        tuple(str(reason) for reason in reasons if reason),
        {str(name): variable.values for name, variable in group.data_vars.items()},
    )


def _as_dataset(resume: ResumePoint) -> xr.Dataset:
    """Return the group of a file; every array has dimensions of its own."""
    arrays = {name: np.asarray(array) for name, array in resume.saved.items()}
    return xr.Dataset(
        {
            name: ([f"{name}_{axis}" for axis in range(array.ndim)], array)
            for name, array in arrays.items()
        },
        attrs={"tried": resume.tried, "reasons": list(resume.reasons) or ""},
    )


@contextmanager
def _netcdf_errors(path: Path) -> Iterator[None]:
    """Turn the RuntimeErrors of the NetCDF library, as on a full disk, into those of a file."""
    try:
        yield
    except RuntimeError as error:
        raise OSError(errno.EIO, str(error), str(path)) from error


def _why_unreadable(path: Path) -> str:
    if path.is_dir():
        return "is a folder"
    return "not a whole NetCDF file" if path.exists() else "no such file"


def _check_schema(path: str | Path, found: Any) -> None:
    field = f"result file {path}: schema_version = {found}"
    if not isinstance(found, (int, np.integer)):
        raise InputError(f"{field}, expected a whole number up to {SCHEMA_VERSION}")
    if found > SCHEMA_VERSION:
        raise InputError(
            f"{field}, expected at most {SCHEMA_VERSION}: made by a newer version of this package"
        )
