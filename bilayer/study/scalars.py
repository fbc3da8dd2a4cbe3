"""The scalars of one result file, a number per milestone, read without the shapes."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.results.conformity import SCALAR_DIMS, check_scalars
from bilayer.results.files import RESULT_FILE
from bilayer.results.netcdf import StoredGroup, read_netcdf_files


@dataclass(frozen=True, eq=False)
class Scalars:
    """The scalars and attributes of a result, without its shapes.

    Parameters
    ----------
    values : mapping of str to array
        Variables by name, shape (milestones,) or (milestones, 3), as float.
    variable_attributes : mapping of str to mapping
        Attributes of each variable.
    attributes : mapping
        Attributes of the file.
    triangles : int
        Number of triangles of the planar mesh.
    """

    values: Mapping[str, NDArray[np.float64]]
    variable_attributes: Mapping[str, Mapping[str, Any]]
    attributes: Mapping[str, Any]
    triangles: int

    def check_milestones(self, path: str | Path, expected: int) -> None:
        """Raise InputError unless the file has as many milestones as its case."""
        found = len(self.values["converged"])
        if found != expected:
            raise InputError(
                f"{RESULT_FILE} {path}: has {found} milestones, expected {expected} as in the "
                "study's plan"
            )


def read_scalars(path: str | Path) -> Scalars:
    """Read the scalars of a result file.

    Raises
    ------
    InputError
        The file cannot be read, or is no result.
    """
    (found,) = read_scalars_of([path])
    if isinstance(found, InputError):
        raise found
    return found


def read_scalars_of(paths: Iterable[str | Path]) -> list[Scalars | InputError]:
    """Read the scalars of many result files, or why one of them cannot be read."""
    listed = list(paths)
    found = read_netcdf_files(listed, RESULT_FILE, partial(StoredGroup.of, dims=SCALAR_DIMS))
    return [_checked(path, stored) for path, stored in zip(listed, found, strict=True)]


def _checked(path: str | Path, stored: StoredGroup | InputError) -> Scalars | InputError:
    if isinstance(stored, InputError):
        return stored
    try:
        check_scalars(stored)
        return _as_scalars(stored)
    except InputError as error:
        return InputError(f"{RESULT_FILE} {path}: {error}")


def _as_scalars(stored: StoredGroup) -> Scalars:
    numbers = {
        name: (values, attributes)
        for name, (dims, values, attributes) in stored.variables.items()
        if name not in dims and values.dtype.kind in "fiu"
    }
    return Scalars(
        {name: np.asarray(values, dtype=float) for name, (values, _) in numbers.items()},
        {name: _lasting(attributes) for name, (_, attributes) in numbers.items()},
        _lasting(stored.attributes),
        stored.sizes.get("face", 0),
    )


def _lasting(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes that mean something away from the file."""
    bound = ("_FillValue", "coordinates")
    return {name: value for name, value in attributes.items() if name not in bound}
