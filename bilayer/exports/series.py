"""All milestones of a result as one time series, which ParaView plays.

A .pvd file names one .vtu file beside it for each milestone that was reached; a .vtkhdf file holds
all of them. The time of a shape is that after the release if the result has times, else its
prestretch, or its number if that does not rise from one to the next.
"""

from collections.abc import Iterable
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.exports.conversion import as_meshio, reached, shape_data
from bilayer.exports.frame import Axes
from bilayer.exports.shapes import MeshData
from bilayer.exports.vtkhdf import write_vtkhdf
from bilayer.mesh.files import write_mesh_data
from bilayer.results.milestones import along_milestones
from bilayer.runtime.output_file import HDF5_ROOM, check_writable, whole_file

COLLECTION, IN_ONE_FILE = ".pvd", ".vtkhdf"
SERIES = (COLLECTION, IN_ONE_FILE)
"""Endings of time series."""
IN_BODY_FRAME = Axes("body", "m")


def convert_series(
    result: xr.Dataset,
    path: str | Path,
    part: str = "midsurface",
    *,
    fields: xr.Dataset | None = None,
    axes: Axes = IN_BODY_FRAME,
) -> list[Path]:
    """Write all milestones that were reached as one time series.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    path : path-like
        A name in .vtkhdf, or in .pvd; shape.pvd has its shapes in shape_0.vtu, shape_1.vtu, ...
        beside it. A .vtkhdf needs the package h5py.
    part, fields
        See `bilayer.convert`.
    axes : Axes
        Frame and unit; each shape in its own body frame, in m, if left out.

    Returns
    -------
    list of Path
        The files written, the one asked for first.

    Raises
    ------
    InputError
        No milestone was reached, the ending is another, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk; nothing is left then. Or h5py is missing.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> paths = bilayer.convert_series(result, folder / "shape.pvd", "volume")
    """
    target = Path(path)
    if target.suffix.lower() not in SERIES:
        raise InputError(f"time series {path}: expected a name in {' or '.join(SERIES)}")
    result = along_milestones(result)
    places = reached(result)
    names = series_names(result, target)
    for name in names:
        check_writable(name)
    times = _times(result, places)
    shapes = (shape_data(result, int(place), part, fields, axes) for place in places)
    with whole_file(target, "time series", _room(result)) as partial:
        if len(names) == 1:
            write_vtkhdf(partial, shapes, times)
        else:
            _write_collection(partial, shapes, times, [name.name for name in names[1:]])
    return names


def series_names(result: xr.Dataset, path: str | Path) -> list[Path]:
    """Return the names of the files of `convert_series`."""
    target = Path(path)
    if target.suffix.lower() == IN_ONE_FILE:
        return [target]
    count = len(reached(along_milestones(result)))
    return [target, *(target.with_name(f"{target.stem}_{k}.vtu") for k in range(count))]


def _room(result: xr.Dataset) -> int:
    """Return the bytes that the shapes take at least, before they are compressed."""
    return int(2 * result["position"].nbytes) + HDF5_ROOM


def _times(result: xr.Dataset, places: NDArray[np.int64]) -> list[float]:
    name = "time" if "time" in result.variables else "prestretch"
    values = result[name].values[places]
    rising = bool(np.all(np.diff(values) > 0))
    return [float(t) for t in (values if rising else np.arange(len(values)))]


def _write_collection(
    path: Path, shapes: Iterable[MeshData], times: list[float], names: list[str]
) -> None:
    for shape, name in zip(shapes, names, strict=True):
        write_mesh_data(as_meshio(shape), path.with_name(name))
    path.write_text(_collection(times, names), "utf-8")


def _collection(times: list[float], names: list[str]) -> str:
    entries = "\n".join(
        f'    <DataSet timestep="{time!r}" file={quoteattr(name)}/>'
        for time, name in zip(times, names, strict=True)
    )
    return (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        f"{entries}\n  </Collection>\n</VTKFile>\n"
    )
