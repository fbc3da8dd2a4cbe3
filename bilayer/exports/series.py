"""All milestones of a result as one time series, which ParaView plays: a .pvd file and its shapes.

The .pvd file names one .vtu file beside it for each milestone that was reached. The time of a shape
is that after the release if the result has times, else its prestretch, or its number if that does
not rise from one to the next.
"""

from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.exports.conversion import as_meshio, reached, shape_data
from bilayer.exports.frame import Axes
from bilayer.mesh.files import write_mesh_data
from bilayer.results.milestones import along_milestones
from bilayer.runtime.output_file import check_writable, whole_file

ENDING = ".pvd"
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
        A name in .pvd; shape.pvd has its shapes in shape_0.vtu, shape_1.vtu, ... beside it.
    part, fields
        See `bilayer.convert`.
    axes : Axes
        Frame and unit; each shape in its own body frame, in m, if left out.

    Returns
    -------
    list of Path
        The files written, the .pvd file first.

    Raises
    ------
    InputError
        No milestone was reached, the ending is another, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk; nothing is left then.

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
    if target.suffix.lower() != ENDING:
        raise InputError(f"time series {path}: expected a name in {ENDING}")
    result = along_milestones(result)
    places = reached(result)
    names = series_names(result, target)
    for name in names:
        check_writable(name)
    with whole_file(target, "time series") as partial:
        for place, name in zip(places, names[1:], strict=True):
            data = shape_data(result, int(place), part, fields, axes)
            write_mesh_data(as_meshio(data), partial.with_name(name.name))
        times = _times(result, places)
        partial.write_text(_collection(times, [name.name for name in names[1:]]), "utf-8")
    return names


def series_names(result: xr.Dataset, path: str | Path) -> list[Path]:
    """Return the names of the files of `convert_series`."""
    target = Path(path)
    count = len(reached(along_milestones(result)))
    return [target, *(target.with_name(f"{target.stem}_{k}.vtu") for k in range(count))]


def _times(result: xr.Dataset, places: NDArray[np.int64]) -> list[float]:
    name = "time" if "time" in result.variables else "prestretch"
    values = result[name].values[places]
    rising = bool(np.all(np.diff(values) > 0))
    return [float(t) for t in (values if rising else np.arange(len(values)))]


def _collection(times: list[float], names: list[str]) -> str:
    entries = "\n".join(
        f'    <DataSet timestep="{time!r}" file={quoteattr(name)}/>'
        for time, name in zip(times, names, strict=True)
    )
    return (
        '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n  <Collection>\n'
        f"{entries}\n  </Collection>\n</VTKFile>\n"
    )
