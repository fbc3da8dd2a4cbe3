"""A result as mesh files for ParaView and others: one file per shape.

The middle surface is the reference surface on the planar mesh. The volume, if a solver kept it,
is read from `volume_position` (prestretch, volume_node, xyz), `volume_reference_position`,
`volume_cells` (volume_cell, vertex: tetrahedra) and `layer` (volume_cell:
0 substrate, 1 kirigami).
"""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.files import check_mesh_output, write_mesh_file
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
) -> None:
    """Write one shape in any format that meshio writes, chosen by the file's ending.

    Points are the deformed ones, in m; `reference_position` and `displacement` go with them, and
    with each cell its `region` (0 bare, 1 kirigami) or `layer` (0 substrate, 1 kirigami).

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

    Raises
    ------
    InputError
        The milestone was not reached or is not there, the result has no volume, the format is
        unknown, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk.
    """
    result = along_milestones(result)
    _write(result, path, _reached(result, prestretch)[-1], part)


def convert_milestones(
    result: xr.Dataset, path: str | Path, part: str = "midsurface"
) -> list[Path]:
    """Write every shape that was reached, each to a file of its own; see `convert`.

    The prestretch is put before the ending: shape.vtu becomes shape_1.03.vtu, shape_1.06.vtu, ...,
    and shape_1.03_2.vtu for a second milestone with that prestretch.

    Returns
    -------
    list of Path
        The files written.
    """
    names = milestone_names(result, path)
    for name in names:
        check_mesh_output(name)
    result = along_milestones(result)
    milestones = _reached(result, None)
    for milestone, name in zip(milestones, names, strict=True):
        _write(result, name, int(milestone), part)
    return names


def milestone_names(result: xr.Dataset, path: str | Path) -> list[Path]:
    """Return the names of the files of `convert_milestones`."""
    result = along_milestones(result)
    milestones = _reached(result, None)
    return _with_prestretches(Path(path), result["prestretch"].values[milestones])


def _write(result: xr.Dataset, path: str | Path, milestone: int, part: str) -> None:
    shape_of = PARTS[one_of("part", part, PARTS)]
    write_mesh_file(shape_of(result.isel(prestretch=milestone)), path)


def _reached(result: xr.Dataset, prestretch: float | None) -> NDArray[np.int64]:
    """Places of the milestones that were reached, or of the one that is asked for."""
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


def _midsurface(shape: xr.Dataset) -> "meshio.Mesh":
    return _mesh(
        shape["reference_position"].values,
        shape["position"].values,
        ("triangle", shape["face_nodes"].values),
        {"region": [shape["region"].values.astype(np.int32)]},
    )


def _volume(shape: xr.Dataset) -> "meshio.Mesh":
    if "volume_position" not in shape:
        raise InputError(
            f"part = 'volume': this result of {shape.attrs['solver']} {shape.attrs['model']} has "
            "no volume, expected 'midsurface'"
        )
    return _mesh(
        shape["volume_reference_position"].values,
        shape["volume_position"].values,
        ("tetra", shape["volume_cells"].values),
        {"layer": [shape["layer"].values.astype(np.int32)]},
    )


PARTS: "dict[str, Callable[[xr.Dataset], meshio.Mesh]]" = {
    "midsurface": _midsurface,
    "volume": _volume,
}


def _mesh(
    reference: NDArray[np.float64],
    position: NDArray[np.float64],
    cells: tuple[str, NDArray[np.int64]],
    cell_data: dict[str, list[NDArray[np.int32]]],
) -> "meshio.Mesh":
    import meshio  # takes long to load, and few need it

    on_points = {"reference_position": reference, "displacement": position - reference}
    return meshio.Mesh(position, [cells], point_data=on_points, cell_data=cell_data)
