"""The formats of mesh files by their endings, and what each of them holds.

meshio knows more endings: what it writes of those cannot be read, or it fails on our meshes.
"""

from pathlib import Path
from typing import Literal

from bilayer.errors import InputError

Cells = Literal["triangles", "volume"]
"""Of a mesh: the triangles of a surface, or the tetrahedra or wedges of a body."""

WITH_LAYERS = (".msh", ".vtu", ".vtk", ".xdmf", ".xmf", ".med", ".hmf", ".dat", ".tec", ".xml")
"""Endings of the formats that hold which layers lie on each cell, and fields."""
CELLS_ALONE = (
    ".avs", ".dato", ".e", ".ex2", ".exo", ".inp", ".mdpa", ".mesh", ".meshb", ".post", ".vol",
)  # fmt: skip
"""Endings of those that hold points and cells alone."""
TRIANGLES_ALONE = (".obj", ".off", ".ply", ".stl")
"""Endings of those that hold points and triangles alone; of a body they keep nothing."""
VOLUMES_ALONE = (".f3grid", ".ugrid")
"""Endings of those that hold a body alone."""
HOLD = {
    "triangles": WITH_LAYERS + CELLS_ALONE + TRIANGLES_ALONE,
    "volume": WITH_LAYERS + CELLS_ALONE + VOLUMES_ALONE,
}
"""Endings of the formats, by the cells that they hold."""


def check_holds_cells(path: str | Path, cells: Cells) -> None:
    """Raise InputError unless a mesh file can hold a mesh of such cells.

    Parameters
    ----------
    path : path-like
        The file; its ending tells the format.
    cells : {"triangles", "volume"}
        Of the mesh.
    """
    if Path(path).suffix.lower() in HOLD[cells]:
        return
    others = [name for name, endings in HOLD.items() if Path(path).suffix.lower() in endings]
    why = f"holds {others[0]}, no {cells}" if others else "cannot be written"
    raise InputError(
        f"mesh file {path}: {why}, expected an ending of {', '.join(sorted(HOLD[cells]))}"
    )


def check_holds_layers(path: str | Path) -> None:
    """Raise InputError unless a mesh file can hold which layers lie on each triangle."""
    check_holds_cells(path, "triangles")
    if Path(path).suffix.lower() not in WITH_LAYERS:
        raise InputError(
            f"mesh file {path}: cannot hold which layers lie on each triangle, expected an ending "
            f"of {', '.join(WITH_LAYERS)}"
        )
