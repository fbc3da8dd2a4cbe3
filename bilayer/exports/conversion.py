"""A result as mesh files for ParaView and others: one file per shape.

The midsurface is the reference surface on the planar mesh; the volume is the layers.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.exports.frame import Axes, usual_unit
from bilayer.exports.shapes import PARTS, MeshData
from bilayer.mesh.files import check_mesh_output, write_mesh_file
from bilayer.mesh.formats import HOLD, TRIANGLES_ALONE
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import SAME_STRETCH
from bilayer.validation import one_of

if TYPE_CHECKING:
    import meshio


def convert(
    result: xr.Dataset,
    path: str | Path,
    prestretch: float | None = None,
    part: str = "midsurface",
    *,
    fields: xr.Dataset | None = None,
    axes: Axes | None = None,
) -> None:
    """Write one shape in any format that meshio writes, chosen by the file's ending.

    Points are the deformed ones; `reference_position` and `displacement` go with them, and with
    each cell its `region` (0 bare, 1 kirigami) or `layer` (0 substrate, 1 kirigami). Fields have
    their unit in their name, such as "cauchy_stress.substrate.top [Pa]".

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    path : path-like
        The file.
    prestretch : float, optional
        Which milestone; the last one that was reached if left out.
    part : {"midsurface", "volume"}
        What to write.
    fields : Dataset, optional
        Those of the result, from `bilayer.fields`, to be written as data.
    axes : Axes, optional
        Frame and unit; if left out the frame of the result, in m, in `.stl .obj .ply .off` in mm.

    Raises
    ------
    InputError
        The milestone was not reached or is not there, the format is unknown, or the folder cannot
        be written.
    ComputationError
        Writing failed, for example on a full disk.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> bilayer.convert(result, folder / "shape.vtu")
    >>> (folder / "shape.vtu").exists()
    True
    """
    result = along_milestones(result)
    write_shape(result, path, int(reached(result, prestretch)[-1]), part, fields, axes)


def convert_milestones(
    result: xr.Dataset,
    path: str | Path,
    part: str = "midsurface",
    *,
    fields: xr.Dataset | None = None,
    axes: Axes | None = None,
) -> list[Path]:
    """Write every shape that was reached, each to a file of its own; see `convert`.

    The prestretch is put before the ending: shape.vtu becomes shape_1.03.vtu, shape_1.06.vtu, ...,
    and shape_1.03_2.vtu for a second milestone with that prestretch.

    Returns
    -------
    list of Path
        The files written.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> paths = bilayer.convert_milestones(result, folder / "shape.vtu")
    >>> [path.name for path in sorted(folder.glob("*.vtu"))]
    ['shape_1.03.vtu']
    """
    names = milestone_names(result, path)
    for name in names:
        check_shape_output(name, part=part)
    result = along_milestones(result)
    for milestone, name in zip(reached(result), names, strict=True):
        write_shape(result, name, int(milestone), part, fields, axes)
    return names


def check_shape_output(
    path: str | Path, inputs: Iterable[str | Path] = (), part: str = "midsurface"
) -> None:
    """Raise InputError unless a part of a shape can be written: before it is made.

    Parameters
    ----------
    path : path-like
        Where it shall be; its ending tells the format.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    part : {"midsurface", "volume"}
        See `convert`.
    """
    if part == "volume" and Path(path).suffix.lower() in TRIANGLES_ALONE:
        raise InputError(
            f"mesh file {path}: holds triangles, no volume, expected --solid for the closed "
            f"surface of the body, or an ending of {', '.join(sorted(HOLD['volume']))}"
        )
    check_mesh_output(path, inputs, "triangles" if part == "midsurface" else "volume")


def milestone_names(result: xr.Dataset, path: str | Path) -> list[Path]:
    """Return the names of the files of `convert_milestones`."""
    result = along_milestones(result)
    return _with_prestretches(Path(path), result["prestretch"].values[reached(result)])


def write_shape(
    result: xr.Dataset,
    path: str | Path,
    milestone: int,
    part: str,
    fields: xr.Dataset | None,
    axes: Axes | None,
) -> None:
    """Write the milestone of a place; see `convert`."""
    if axes is None:
        axes = Axes(unit=usual_unit(path))
    write_mesh_file(as_meshio(shape_data(result, milestone, part, fields, axes)), path)


def shape_data(
    result: xr.Dataset, milestone: int, part: str, fields: xr.Dataset | None, axes: Axes
) -> MeshData:
    """Return the milestone of a place as a mesh; see `convert`."""
    shape_of = PARTS[one_of("part", part, PARTS)]
    own = None if fields is None else along_milestones(fields).isel(prestretch=milestone)
    return shape_of(result.isel(prestretch=milestone), axes, own)


def reached(result: xr.Dataset, prestretch: float | None = None) -> NDArray[np.int64]:
    """Return the places of the milestones that were reached, or of those that are asked for.

    Raises
    ------
    InputError
        There is none.
    """
    converged = result["converged"].values.astype(bool)
    stretches = result["prestretch"].values
    if prestretch is not None:
        converged &= np.abs(stretches - prestretch) < SAME_STRETCH
    if not converged.any():
        listed = ", ".join(f"{s:g}" for s in stretches[result["converged"].values == 1])
        asked = "" if prestretch is None else f"prestretch = {prestretch:g}: "
        raise InputError(f"{asked}expected a milestone that was reached ({listed or 'none was'})")
    return np.flatnonzero(converged)


def _with_prestretches(path: Path, stretches: NDArray[np.float64]) -> list[Path]:
    texts = [f"{stretch:.10g}" for stretch in stretches]
    counts = [texts[:k].count(text) + 1 for k, text in enumerate(texts)]
    ends = [text if n == 1 else f"{text}_{n}" for text, n in zip(texts, counts, strict=True)]
    return [path.with_name(f"{path.stem}_{end}{path.suffix}") for end in ends]


def as_meshio(data: MeshData) -> "meshio.Mesh":
    """Return a mesh with data as meshio has it."""
    import meshio  # takes long to load, and few need it

    on_cells = {name: [values] for name, values in data.cell_data.items()}
    cells = [(data.kind, data.cells)]
    return meshio.Mesh(data.points, cells, point_data=data.point_data, cell_data=on_cells)
