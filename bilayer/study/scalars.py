"""The scalars of one result file, a number per milestone, read without the shapes."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import netCDF4
import numpy as np
from numpy.typing import NDArray
from xarray.backends.locks import HDF5_LOCK

from bilayer.errors import InputError

DIMENSIONS = (("prestretch",), ("prestretch", "xyz"))


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


def read_scalars(path: str | Path) -> Scalars:
    """Read the scalars of a result file.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    try:
        with HDF5_LOCK, netCDF4.Dataset(path) as stored:  # the library is not safe for threads
            stored.set_auto_mask(False)
            chosen = {
                name: variable
                for name, variable in stored.variables.items()
                if variable.dimensions in DIMENSIONS and name not in variable.dimensions
            }
            return Scalars(
                {name: np.asarray(variable[:], dtype=float) for name, variable in chosen.items()},
                {name: _attributes(variable) for name, variable in chosen.items()},
                _attributes(stored),
                stored.dimensions["face"].size,
            )
    except (OSError, RuntimeError, KeyError) as error:
        raise InputError(f"result file {path}: cannot be read ({error})") from error


def _attributes(holder: Any) -> dict[str, Any]:
    """Return the attributes that mean something away from the file."""
    names = [name for name in holder.ncattrs() if name not in ("_FillValue", "coordinates")]
    return {name: holder.getncattr(name) for name in names}
