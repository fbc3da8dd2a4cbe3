"""The points of a scan: of a mesh as many as its area asks for, or those of a table."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface
from bilayer.mesh.files import read_mesh_file
from bilayer.runtime.input_file import read_text
from bilayer.scan.samples import even_samples
from bilayer.validation import positive

Array = NDArray[np.float64]
MESHES = (".stl", ".ply", ".obj", ".off", ".vtk", ".vtu")
TABLES = (".csv", ".xyz", ".txt", ".asc")
MOST_POINTS = 100_000
LARGEST_TABLE = 2**29
LEAST_POINTS = 20


@dataclass(frozen=True)
class Cloud:
    """Points on a part.

    Parameters
    ----------
    name : str
        Of the file.
    points : ndarray, shape (n, 3)
        m.

    Examples
    --------
    >>> import bilayer, numpy as np
    >>> points = np.random.default_rng(0).normal(size=(50, 3))
    >>> bilayer.Cloud("made up", points).points.shape
    (50, 3)
    """

    name: str
    points: Array

    def __post_init__(self) -> None:
        if self.points.ndim != 2 or self.points.shape[1] != 3 or len(self.points) < LEAST_POINTS:
            raise InputError(
                f"scan {self.name}: has shape {self.points.shape}, expected at least "
                f"{LEAST_POINTS} points (n, 3)"
            )
        if not np.isfinite(self.points).all():
            raise InputError(f"scan {self.name}: expected finite coordinates")


def read_cloud(path: str | Path, unit: float = 1e-3) -> Cloud:
    r"""Read a scan.

    Parameters
    ----------
    path : path-like
        A triangulated surface (STL, PLY, OBJ, OFF, VTK), or a table of x, y, z with or without a
        line of names (CSV, XYZ), such as a height map. Its points without a height ("nan", or
        nothing in the third column) are left out.
    unit : float
        One unit of its coordinates, m; most are in mm.

    Raises
    ------
    InputError
        It cannot be read, or holds no points of a surface.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "part.csv"
    >>> _ = file.write_text("\n".join(f"{k},{k * k},0" for k in range(30)))
    >>> bilayer.read_cloud(file).points.max(axis=0)
    array([0.029, 0.841, 0.   ])
    """
    source, unit = Path(path), positive("unit", unit, "m")
    ending = source.suffix.lower()
    if ending in TABLES:
        return Cloud(source.name, unit * read_table(source))
    if ending not in MESHES:
        raise InputError(f"scan {source}: expected a name in {', '.join((*MESHES, *TABLES))}")
    mesh, _ = read_mesh_file(source)
    points = np.asarray(mesh.points, dtype=np.float64)
    triangles = mesh.get_cells_type("triangle")
    if points.shape[1:] == (2,):
        points = np.column_stack([points, np.zeros(len(points))])
    if len(triangles) == 0:  # a cloud of points
        return Cloud(source.name, unit * points)
    return Cloud(source.name, unit * even_samples(Surface(points, triangles), MOST_POINTS).points)


def read_table(path: Path, columns: int = 3) -> Array:
    """Return the first columns of a table of numbers, shape (n, columns).

    Rows without a number in the last of them are left out.
    """
    lines = read_text(path, "scan", largest=LARGEST_TABLE).splitlines()
    lines = [f"{line}nan" if line.rstrip().endswith((",", ";")) else line for line in lines]
    rows = [line.replace(";", " ").replace(",", " ").split() for line in lines]
    rows = [row for row in rows if row and not row[0].startswith("#")]
    if rows and not _is_number(rows[0][0]):
        rows = rows[1:]
    try:
        full = [[float(value) for value in row[:columns]] for row in rows]
        points = np.array(full, dtype=np.float64)
        return points[~np.isnan(points[:, -1])] if points.ndim == 2 else points
    except ValueError as error:
        raise InputError(
            f"scan {path}: expected {columns} numbers on each line ({error})"
        ) from error


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
