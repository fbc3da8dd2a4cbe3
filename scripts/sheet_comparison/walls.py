"""The shell whose layers are relieved at walls, `solver.walls = relieved`, on the same sheets."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import bilayer
from bilayer import MorleySettings
from sheet_comparison.branches import distance, energy
from sheet_comparison.cases import TOLERANCE, Case
from sheet_comparison.rows import Row, Runs, SheetRow, pair_at

RELIEVED = MorleySettings(walls="relieved")


@dataclass(frozen=True)
class WallRow(SheetRow):
    """What the relieved shell came to from the shape of the shell beside it.

    `distance`, `height` and `energy_ratio` (finite elements over shell) are as in `Row`.
    """

    distance: float
    height: float
    energy_ratio: float
    unstable: int


def beside(row: Row, walls: Sequence[WallRow]) -> WallRow | None:
    """Return the relieved shell's row of a sheet on its mesh, if there is one."""
    return next((found for found in walls if found.milestone == row.milestone), None)


def is_missed(row: Row, walls: Sequence[WallRow]) -> bool:
    """Return whether the solvers must agree on a sheet, and the relieved shell does not."""
    found = beside(row, walls)
    return row.is_judged and (found is None or not found.distance <= TOLERANCE)


def wall_rows(case: Case, rows: Sequence[Row], kept: Path) -> Iterator[WallRow]:
    """Compute the relieved shell at milestones of a case.

    Parameters
    ----------
    case : Case
        The sheet, on a mesh.
    rows : sequence of Row
        Of that case, each with a shape by both solvers.
    kept : Path
        Folder of the results; those that are there are not computed again.
    """
    runs = Runs(case, bilayer.generate_mesh(case.specimen), kept)
    for row in rows:
        pair = pair_at(row.prestretch, runs)
        relieved = runs.started(row.prestretch, "relieved", RELIEVED, pair.shell)
        yield WallRow(
            row.sheet,
            row.pile,
            row.thickness,
            row.is_published,
            row.prestretch,
            row.mesh_size,
            distance(pair.solid, relieved),
            relieved["height"].item() / case.specimen.characteristic_length,
            energy(pair.solid) / energy(relieved),
            relieved["unstable_modes"].item(),
        )
