"""Result files: NetCDF, whole or not there, and those of runs that are not finished.

The file of a run that is not finished has a group `resume` beside the dataset: all that its path
needs to go on from the last milestone. A finished one has none.
"""

import errno
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.results.conformity import check_result
from bilayer.results.netcdf import StoredGroup, read_netcdf, why_not_locked
from bilayer.runtime.output_file import HDF5_ROOM, check_writable, trial_file, whole_file
from bilayer.validation import LARGEST

RESUME_GROUP = "resume"
RESULT_FILE = "result file"
ENDINGS = (".nc", ".nc4", ".cdf")


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


def check_result_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless a result can be written: before it is computed.

    The NetCDF library makes a trial file, which tells of file systems without locks.

    Parameters
    ----------
    path : path-like
        Where it shall be.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    """
    check_writable(path, inputs)
    if Path(path).suffix.lower() not in ENDINGS:
        raise InputError(
            f"output file {path}: a result is NetCDF, expected an ending of {', '.join(ENDINGS)}"
        )
    with trial_file(path) as trial:
        try:
            netCDF4.Dataset(trial, "w").close()
        except (OSError, RuntimeError) as error:
            with tempfile.TemporaryFile(dir=trial.parent) as file:
                reason = why_not_locked(file.fileno()) or getattr(error, "strerror", None) or error
            raise InputError(f"output file {path}: cannot be written ({reason})") from error


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

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> bilayer.write_result(result, folder / "shell.nc")
    """
    group = None if resume is None else _as_dataset(resume)
    room = result.nbytes + (0 if group is None else group.nbytes) + HDF5_ROOM
    with whole_file(path, "result file", room=room) as partial, _netcdf_errors(partial):
        if group is None:
            _write_packed(result, partial)
        else:
            _write_quickly(result, group, partial)


def _write_packed(result: xr.Dataset, path: Path) -> None:
    packed: dict[Any, dict[str, Any]] = {
        name: {"zlib": True, "complevel": 4}
        for name, variable in result.variables.items()
        if variable.dtype.kind == "f" and variable.ndim > 1
    }
    without_gaps = {name: {"_FillValue": None} for name in result.coords}  # CF, section 2.5.1
    result.to_netcdf(path, engine="netcdf4", encoding=packed | without_gaps)


def _write_quickly(result: xr.Dataset, group: xr.Dataset, path: Path) -> None:
    """Write what xarray would read back the same, in a quarter of the time that it takes."""
    with netCDF4.Dataset(path, "w") as file:
        _fill(file, result)
        _fill(file.createGroup(RESUME_GROUP), group)


def _fill(group: netCDF4.Dataset, dataset: xr.Dataset) -> None:
    """Define everything before anything is written: the library syncs in between."""
    for name, size in dataset.sizes.items():
        group.createDimension(str(name), size)
    group.setncatts(dataset.attrs)
    made = []
    for name, variable in dataset.variables.items():
        is_text = variable.dtype.kind in "OU"
        gaps = np.nan if variable.dtype.kind == "f" and name not in dataset.coords else False
        kind: Any = str if is_text else variable.dtype.str[1:]  # without the order of bytes
        dims = [str(dim) for dim in variable.dims]
        stored = group.createVariable(str(name), kind, dims, fill_value=None if is_text else gaps)
        stored.setncatts(variable.attrs | _coordinates(dataset, name))
        made.append((stored, variable.values.astype(object) if is_text else variable.values))
    for stored, values in made:
        stored[...] = values


def _coordinates(dataset: xr.Dataset, name: Any) -> dict[str, str]:
    """Return the attribute that names the coordinates of a variable which are no dimensions."""
    if name in dataset.coords:
        return {}
    dims = set(dataset.variables[name].dims)
    own = [
        str(coordinate)
        for coordinate, values in dataset.coords.items()
        if coordinate not in dataset.sizes and set(values.dims) <= dims
    ]
    return {"coordinates": " ".join(own)} if own else {}


def open_result(path: str | Path) -> xr.Dataset:
    """Read a result into memory.

    Raises
    ------
    InputError
        The file is missing or damaged, is no result, or has a newer schema.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> bilayer.write_result(result, folder / "shell.nc")
    >>> float(bilayer.open_result(folder / "shell.nc")["height"]) == float(result["height"])
    True
    """
    stored = read_netcdf(path, RESULT_FILE, StoredGroup.of)
    with _named(path):
        try:
            result = stored.decoded()
        except Exception as error:  # whatever xarray meets in what is stored
            raise InputError(f"is no dataset ({' '.join(str(error).split())})") from error
        check_result(result)
    return result


def open_resume_point(path: str | Path) -> ResumePoint | None:
    """Return the point from which the run of a file can be resumed; None if it is finished.

    Raises
    ------
    InputError
        The file cannot be read, or its group is none of a resume point.
    """
    group = read_netcdf(path, RESULT_FILE, _resume_group)
    if group is None:
        return None
    with _named(path):
        tried, reasons = (group.attributes.get(name) for name in ("tried", "reasons"))
        reasons = np.atleast_1d(np.asarray(reasons, dtype=object))
        if not isinstance(tried, (int, np.integer)) or tried < 0:
            raise InputError(f"{RESUME_GROUP}: tried = {tried!r}, expected a whole number")
        if not all(isinstance(reason, str) for reason in reasons):
            raise InputError(f"{RESUME_GROUP}: reasons = {reasons.tolist()!r}, expected texts")
        saved = {name: values for name, (_, values, _) in group.variables.items()}
        for name, values in saved.items():
            if values.dtype.kind == "f" and not (np.abs(values) <= LARGEST).all():  # nor a nan
                raise InputError(f"{RESUME_GROUP}: {name} holds values that are no finite numbers")
    return ResumePoint(int(tried), tuple(reason for reason in reasons if reason), saved)


def _resume_group(stored: netCDF4.Dataset) -> StoredGroup | None:
    group = stored.groups.get(RESUME_GROUP)
    return None if group is None else StoredGroup.of(group)


@contextmanager
def _named(path: str | Path) -> Iterator[None]:
    """Say of an InputError which file it is about."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{RESULT_FILE} {path}: {error}") from error


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
