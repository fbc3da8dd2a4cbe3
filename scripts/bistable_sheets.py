"""The published bistable sheets: their states by prestretch, barriers, and from when they have two.

Started by scripts/bistable_sheets, which sets the environment up. What is computed is not computed
again: the numbers are in two files of comma-separated values, the states in a folder.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from bistable.cases import MILESTONES, SHARES, Case, cases
from bistable.page import page
from bistable.picture import draw
from bistable.rows import Point, Row, descent, row_of
from sheet_comparison.table import read_table, write_table

import bilayer
from bilayer.runtime.output_file import whole_file
from bilayer.validation import one_of

ROOT = Path(__file__).parents[1]


def main(words: Sequence[str] | None = None) -> int:
    """Compute what is missing; write the page and the figure."""
    options = _options(words)
    options.kept.mkdir(parents=True, exist_ok=True)
    try:
        wanted = list(cases(options.mesh_scale))
        names = [one_of("CASE", name, list(map(str, wanted))) for name in options.cases]
        if names:
            wanted = [case for case in wanted if str(case) in names]
        rows, points = compute(wanted, options.rows, options.paths, options.kept)
    except bilayer.BilayerError as error:
        print(f"scripts/bistable_sheets: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    if options.cases:
        return 0
    with whole_file(options.output, "page") as partial:
        partial.write_text(page(rows, points), encoding="utf-8")
    bilayer.save_figure(draw(rows, points), options.figure)
    return 0


def compute(
    wanted: Sequence[Case], rows_file: Path, paths_file: Path, kept: Path
) -> tuple[list[Row], list[Point]]:
    """Return the rows and the points of the paths, what is missing of them computed."""
    rows, points = read_table(rows_file, Row), read_table(paths_file, Point)
    for case in wanted:
        outer = case.specimen.layers[0].thickness
        if not any(_is_of(row, case, outer) and row.prestretch == case.prestretch for row in rows):
            rows.append(row_of(case, kept))
            write_table(rows_file, rows)
            print(f"{case}: {rows[-1].verdict}", file=sys.stderr, flush=True)
        if case.prestretch == max(MILESTONES) and not any(_is_of(p, case, outer) for p in points):
            points += descent(case, kept)
            write_table(paths_file, points)
    return rows, points


def _is_of(line: Row | Point, case: Case, outer: float) -> bool:
    return line.sheet == case.sheet and abs(line.outer / outer - 1) < 1e-9


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    results = ROOT / "results"
    parser = argparse.ArgumentParser(
        prog="scripts/bistable_sheets",
        description="The states of the published bistable sheets, with outer layers of "
        f"{', '.join(f'{share:g}' for share in SHARES)} of the published thickness.",
    )
    parser.add_argument(
        "cases", nargs="*", metavar="CASE", help="such as lotus_0.25_1.2, and no page; or all"
    )
    parser.add_argument("--rows", type=Path, default=results / "bistable_sheets.csv",
                        help="file of the numbers, which are not computed again")  # fmt: skip
    parser.add_argument("--paths", type=Path, default=results / "bistable_paths.csv",
                        help="file of the heights down to the flat sheet")  # fmt: skip
    parser.add_argument("--kept", type=Path, default=results / "bistable_sheets",
                        help="folder of the states")  # fmt: skip
    parser.add_argument("--mesh-scale", type=float, default=1.0,
                        help="of 3 and 3.75 mm")  # fmt: skip
    parser.add_argument("--figure", type=Path, default=ROOT / "docs/images/bistable_sheets.png")
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs/bistable_sheets.md",
                        help="the page that is written of them")  # fmt: skip
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
