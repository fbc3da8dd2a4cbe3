"""Mesh files in any format that meshio knows, with its messages as errors of this project.

They are read in a child process: on some that are damaged meshio never ends, or a library crashes.
"""

import io
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bilayer.errors import BilayerError, InputError
from bilayer.mesh.formats import Cells, check_holds_cells
from bilayer.mesh.gmsh_files import PhysicalGroups, is_gmsh, read_gmsh
from bilayer.runtime.input_file import unreadable
from bilayer.runtime.output_file import HDF5_ROOM, check_writable, whole_file
from bilayer.runtime.untrusted_file import read_in_child

if TYPE_CHECKING:
    import meshio

FORMATS = {".msh": "gmsh22"}
"""Formats of ambiguous endings: gmsh's 2.2 keeps our order of triangles, 4 sorts by tag."""
NOT_OF_TRIANGLES = (".ele", ".node", ".f3grid", ".svg", ".wkt")
"""Endings that meshio does not read triangles from; at some it never ends."""


WITH_COMPANION = (".xdmf", ".xmf")
"""Endings of formats that keep the numbers in an .h5 file of the same name."""
SHORTEST_TIME, BYTES_PER_SECOND = 10.0, 1e6
"""Seconds that a file may take to be read: so many, and longer the larger it is."""


def read_mesh_file(
    path: str | Path, shortest_time: float = SHORTEST_TIME
) -> "tuple[meshio.Mesh, PhysicalGroups | None]":
    """Return the mesh of a file, the format told by its ending, and its groups if it is gmsh's.

    Parameters
    ----------
    path : path-like
        The file.
    shortest_time : float
        Seconds that any file may take to be read; a large one gets more.

    Raises
    ------
    InputError
        The file is missing, of an unknown format, or not what its ending says.
    """
    import meshio  # noqa: F401  # before the process is copied, so that no copy has to

    if Path(path).suffix.lower() in NOT_OF_TRIANGLES:
        raise InputError(f"mesh file {path}: cannot be read, expected a format of triangles")
    try:
        return read_in_child(
            path, "mesh file", partial(_read, path), shortest_time, BYTES_PER_SECOND
        )
    except OSError as error:
        raise unreadable(path, "mesh file", error.strerror or str(error)) from error


def _read(path: str | Path) -> "tuple[meshio.Mesh, PhysicalGroups | None]":
    import meshio

    with _meshio_speaks_by_errors(path, "read"):
        if Path(path).suffix.lower() == ".msh" and is_gmsh(content := Path(path).read_bytes()):
            return read_gmsh(path, content)
        return meshio.read(path), None


def check_mesh_output(
    path: str | Path, inputs: Iterable[str | Path] = (), cells: Cells = "triangles"
) -> None:
    """Raise InputError unless a mesh file can be written: before there is a mesh.

    Parameters
    ----------
    path : path-like
        Where it shall be; its ending tells the format.
    inputs : iterable of path-like
        Files that are read and must not be lost.
    cells : {"triangles", "volume"}
        Of the mesh.
    """
    target = check_writable(path, inputs)
    check_holds_cells(path, cells)
    ending = Path(path).suffix.lower()
    companion = target.with_name(Path(path).name).with_suffix(".h5")
    if ending in WITH_COMPANION and companion.exists() and not target.exists():
        raise InputError(
            f"mesh file {path}: {companion} is there, which {ending} writes too; expected another "
            "name"
        )


def write_mesh_file(mesh: "meshio.Mesh", path: str | Path) -> None:
    """Write a mesh file, the format told by its ending; whole or not at all.

    Raises
    ------
    InputError
        The format is unknown or cannot hold this mesh, or the folder cannot be written.
    ComputationError
        Writing failed, for example on a full disk.
    """
    is_surface = all(block.type == "triangle" for block in mesh.cells)
    check_mesh_output(path, cells="triangles" if is_surface else "volume")
    arrays = [mesh.points, *(block.data for block in mesh.cells), *mesh.point_data.values()]
    room = sum(np.asarray(array).nbytes for array in arrays) + HDF5_ROOM  # .xdmf has an .h5
    with whole_file(path, "mesh file", room) as partial:
        write_mesh_data(mesh, partial, path)


def write_mesh_data(mesh: "meshio.Mesh", partial: Path, path: str | Path | None = None) -> None:
    """Write a mesh file within a block of `whole_file`; `path` is what messages call it."""
    import meshio

    file_format = FORMATS.get(partial.suffix.lower())
    with _meshio_speaks_by_errors(partial if path is None else path, "written"):
        meshio.write(partial, mesh, file_format=file_format)


@contextmanager
def _meshio_speaks_by_errors(path: str | Path, done: str) -> Iterator[None]:
    """Turn meshio's many ways to fail into an InputError; errors of the disk pass.

    meshio prints its messages, some of them blank lines, and even ends the process; what it
    prints is kept off the terminal and becomes part of the error.
    """
    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed):
            yield
    except (OSError, BilayerError):
        raise
    except (Exception, SystemExit) as error:
        told = str(error) or type(error).__name__
        reason = " ".join([*printed.getvalue().split(), told])
        raise InputError(f"mesh file {path}: cannot be {done} ({reason})") from error
