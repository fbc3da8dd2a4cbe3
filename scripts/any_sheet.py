"""The two solvers against each other on sheets of other outlines and patterns, thin and thick.

Started by scripts/any_sheet, which sets the environment up.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from sheet_comparison.branches import UNKNOWN
from sheet_comparison.cases import MOST_TRIANGLES, Case, cases
from sheet_comparison.cross import CrossRow, cross_rows
from sheet_comparison.page import page
from sheet_comparison.rows import (
    Row,
    on_finest_mesh,
    rows_of,
    rows_on,
    with_sensitivity,
)
from sheet_comparison.table import read_table, write_table
from sheet_comparison.walls import WallRow, beside, is_missed, wall_rows

from bilayer import ComputationError
from bilayer.mesh.generation import estimated_triangles


def main(words: Sequence[str] | None = None) -> int:
    """Compute what is missing of the rows, write the page; 1 if the solvers disagree."""
    parser = argparse.ArgumentParser(
        prog="scripts/any_sheet", description="The two solvers on other sheets, thin and thick."
    )
    parser.add_argument("--rows", type=Path, default=Path("results/any_sheet.csv"),
                        help="file of the numbers, which are not computed again")  # fmt: skip
    parser.add_argument("--cross", type=Path, default=Path("results/any_sheet_cross.csv"),
                        help="file of the numbers of the thin cross by the shell")  # fmt: skip
    parser.add_argument("--walls", type=Path, default=Path("results/any_sheet_walls.csv"),
                        help="file of the numbers of the shell relieved at walls")  # fmt: skip
    parser.add_argument("--kept", type=Path, default=Path("results/any_sheet"),
                        help="folder of the results, which are not computed again")  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/any_sheet.md"),
                        help="the page that is written of them")  # fmt: skip
    options = parser.parse_args(words)
    options.kept.mkdir(parents=True, exist_ok=True)
    rows, walls = read_table(options.rows, Row), read_table(options.walls, WallRow)
    for case in cases():
        rows = with_case(rows, case, options.kept, options.rows)
        walls = with_walls(walls, rows, case, options.kept, options.walls)
    cross = read_table(options.cross, CrossRow)
    if not cross:
        cross = list(cross_rows(options.kept))
        write_table(options.cross, cross)
    options.output.write_text(page(rows, cross, walls))
    missed = [row for row in on_finest_mesh(rows) if is_missed(row, walls)]
    for row in missed:
        print(f"missed: {row}", file=sys.stderr)
    return 1 if missed else 0


def with_case(rows: Sequence[Row], case: Case, kept: Path, path: Path) -> list[Row]:
    """Return the rows with those of a case, on finer meshes, too, while the solvers disagree."""
    on_mesh = rows_on(rows, case)
    try:
        found = completed(case, on_mesh, kept)
    except ComputationError as error:
        print(f"{case}: {error}", file=sys.stderr)
        return list(rows)
    if found != on_mesh:
        rows = [*(row for row in rows if row not in on_mesh), *found]
        write_table(path, rows)
        for row in found:
            print(_line(row), file=sys.stderr, flush=True)
    missed = any(row.is_missed for row in found)
    if missed and estimated_triangles(case.finer.specimen) <= MOST_TRIANGLES:
        return with_case(rows, case.finer, kept, path)
    return list(rows)


def completed(case: Case, rows: Sequence[Row], kept: Path) -> list[Row]:
    """Return the rows of a case on its mesh, what is missing of them computed."""
    missing = {row.prestretch for row in rows} != set(case.specimen.prestretch.nominal)
    if missing or any(row.is_judged and row.state == UNKNOWN for row in rows):
        return list(rows_of(case, kept))
    if any(row.is_judged and np.isnan(row.sensitivity) and row.state == "both" for row in rows):
        return with_sensitivity(case, rows, kept)
    return list(rows)


def with_walls(
    walls: Sequence[WallRow], rows: Sequence[Row], case: Case, kept: Path, path: Path
) -> list[WallRow]:
    """Return the rows of the relieved shell with those of a case on all of its meshes."""
    on_mesh = rows_on(rows, case)
    if not on_mesh:
        return list(walls)
    missing = [row for row in on_mesh if row.is_known and beside(row, walls) is None]
    if missing:
        walls = [*walls, *wall_rows(case, missing, kept)]
        write_table(path, walls)
    return with_walls(walls, rows, case.finer, kept, path)


def _line(row: Row) -> str:
    return (
        f"{row.sheet}, {row.pile}, {row.thickness:.1%}, {row.prestretch:g}, "
        f"{1e3 * row.mesh_size:.3g} mm: {row.distance:.2%} apart, state {row.state}"
    )


if __name__ == "__main__":
    sys.exit(main())
