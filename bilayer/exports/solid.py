"""The body of a shape as a solid with thickness: one closed, outward surface, for slicers and CAD.

Of a result with a volume it is the boundary of that; of any other the skin of the layers on both
sides of the reference surface, which keep their volume (`bilayer.contact.skin`).
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.contact.skin import BondedBody, skin_of
from bilayer.errors import ComputationError
from bilayer.exports.conversion import reached
from bilayer.exports.frame import IN_MM, UNITS, Axes
from bilayer.geometry.surface import Surface, directed_edges
from bilayer.mesh.files import write_mesh_data
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.validation import one_of

if TYPE_CHECKING:
    import meshio

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

BY_TRIMESH = (".glb", ".3mf")
SOLIDS = (*IN_MM, *BY_TRIMESH)
"""Endings of the formats of solids."""
IN_METRES = (".glb",)
"""Formats that are in m by their own rules; glTF also has y upward."""
_FACES = ((1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1))
"""Faces of a tetrahedron of positive volume, seen from outside counterclockwise."""


def convert_solid(
    result: xr.Dataset, path: str | Path, prestretch: float | None = None, *, unit: str = "mm"
) -> None:
    """Write the body of one shape as a closed surface, apex up.

    Parameters
    ----------
    result : Dataset
        See `bilayer.results.schema`.
    path : path-like
        The file: .stl, .obj, .ply, .off, .glb or .3mf. The last two need the package trimesh.
    prestretch : float, optional
        Which milestone; the last one that was reached if left out.
    unit : {"mm", "m"}
        Of the coordinates; a .glb is in m whatever is asked for, with y upward, and a .3mf in mm.

    Raises
    ------
    InputError
        The milestone was not reached, the ending is another, or the folder cannot be written.
    ComputationError
        trimesh is missing, the surface is not closed, or writing failed.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> import pathlib, tempfile
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> bilayer.convert_solid(result, folder / "dome.stl")
    """
    check_solid_output(path)
    ending = Path(path).suffix.lower()
    result = along_milestones(result)
    shape = result.isel(prestretch=int(reached(result, prestretch)[-1]))
    fixed = {".3mf": "mm"} | dict.fromkeys(IN_METRES, "m")
    solid = solid_of(shape, Axes("body", fixed.get(ending, one_of("unit", unit, UNITS))))
    with whole_file(path, "solid") as partial:
        if ending in BY_TRIMESH:
            _write_by_trimesh(solid, partial)
        else:
            write_mesh_data(_as_meshio(solid), partial, path)


def check_solid_output(path: str | Path, inputs: Iterable[str | Path] = ()) -> None:
    """Raise InputError unless a solid can be written: before there is one."""
    check_writable(path, inputs)
    one_of(f"ending of solid {path}", Path(path).suffix.lower(), SOLIDS)


def solid_of(shape: xr.Dataset, axes: Axes) -> Surface:
    """Return the closed surface of one milestone, its triangles turned outward.

    Parameters
    ----------
    shape : Dataset
        One milestone of a result.
    axes : Axes
        Of the points.

    Raises
    ------
    ComputationError
        Some edge does not have a triangle on either side: the layers touch in a line only.
    """
    surface = _boundary(shape) if "volume_position" in shape else _skin(shape)
    used, numbered = np.unique(surface.triangles, return_inverse=True)
    solid = Surface(axes.of(shape).points(surface.points[used]), numbered.reshape(-1, 3))
    _check_closed(solid.triangles)
    return solid


def _skin(shape: xr.Dataset) -> Surface:
    mesh, specimen = result_mesh(shape), result_specimen(shape)
    stretch = float(shape["prestretch_x"]), float(shape["prestretch_y"])
    body = BondedBody.of(specimen, mesh, stretch)
    return skin_of(body, Surface(shape["position"].values, mesh.triangles)).surface


def _boundary(shape: xr.Dataset) -> Surface:
    """Return the faces of the tetrahedra that belong to one of them alone."""
    cells, flat = shape["volume_cells"].values, shape["volume_reference_position"].values
    corners = flat[cells]
    left = np.linalg.det(corners[:, 1:] - corners[:, :1]) < 0
    cells = np.where(left[:, None], cells[:, [0, 1, 3, 2]], cells)
    faces = cells[:, _FACES].reshape(-1, 3)
    _, first, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    return Surface(shape["volume_position"].values, faces[np.sort(first[count == 1])])


def _check_closed(triangles: Indices) -> None:
    """Raise ComputationError unless every edge is run through once in either sense."""
    edges = directed_edges(triangles)
    ends, senses = np.sort(edges, axis=1), np.sign(edges[:, 1] - edges[:, 0])
    _, place, count = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    balance = np.bincount(place.ravel(), senses, minlength=len(count))
    wrong = np.count_nonzero((count != 2) | (balance != 0))
    if wrong:
        raise ComputationError(
            f"solid: {wrong} edges have not one triangle on either side, expected layers that do "
            "not touch each other in a line or a point"
        )


def _as_meshio(solid: Surface) -> "meshio.Mesh":
    import meshio

    return meshio.Mesh(solid.points, [("triangle", solid.triangles)])


def _write_by_trimesh(solid: Surface, path: Path) -> None:
    try:
        import trimesh
    except ImportError as error:
        raise ComputationError(
            f"{path.suffix} needs the package trimesh ({error}): pip install "
            "'bilayer-shells[solids]'"
        ) from error
    points = solid.points
    if path.suffix.lower() in IN_METRES:
        points = points[:, [0, 2, 1]] * [1, 1, -1]  # y upward
    body = trimesh.Trimesh(points, solid.triangles, process=False)
    path.write_bytes(body.export(file_type=path.suffix.lower().removeprefix(".")))
