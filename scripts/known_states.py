"""The stable states of sheets with 4, 6 and 8 strips, and of one on finer meshes, as a table.

Started by scripts/known_states, which sets the environment up. A search goes on from its file, so
that more starts cost only what they add.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import xarray as xr
from sheet_comparison.table import read_table, write_table

import bilayer
from bilayer.runtime.output_file import whole_file

ROOT = Path(__file__).parents[1]
SPECIMEN = Path(__file__).parent / "studies" / "specimen.toml"
SHEETS = ((4, 1.06), (4, 1.15), (6, 1.06), (6, 1.15), (8, 1.06), (8, 1.15))
"""Strips and prestretch, on 6 mm."""
FINER = ((6, 1.06, 0.004), (6, 1.06, 0.003), (6, 1.06, 0.0025))
"""Strips, prestretch and mesh size in m. Each begins with the states on the mesh before."""
FEW = 5
"""Starts on a finer mesh."""
COLUMNS = (
    "strips", "prestretch", "mesh", "starts", "random", "energy, µJ", "quality", "height, mm",
    "found",
)  # fmt: skip
BEGIN, END = "<!-- begin of scripts/known_states -->", "<!-- end of scripts/known_states -->"


@dataclass(frozen=True)
class Row:
    """A state: mesh size in m, energy in J, height in m; `random` of the starts are random."""

    strips: int
    prestretch: float
    mesh: float
    starts: int
    random: int
    energy: float
    quality: float
    height: float
    found: int
    gap: float


def search(
    sheet: bilayer.Specimen, file: Path, starts: int, random: int, start: xr.Dataset | None = None
) -> xr.Dataset:
    """Return the states from at least so many starts, and at least so many random ones."""
    while True:
        found = bilayer.states(
            sheet, starts=starts, start=start, output=file,
            resume=file if file.exists() else None,
        )  # fmt: skip
        missing = random - random_starts(found)
        if missing <= 0:
            return found
        starts = found.sizes["start"] + missing


def random_starts(found: xr.Dataset) -> int:
    """Return how many starts of a search are random shapes."""
    return sum(str(name).startswith("random") for name in found["start_name"].values)


def searched(
    kept: Path, starts: int, random: int
) -> Iterator[tuple[int, float, float, xr.Dataset]]:
    """Yield the search of each sheet, then of one on finer meshes."""
    before: xr.Dataset | None = None
    for strips, stretch, mesh in [*((*sheet, 0.006) for sheet in SHEETS), *FINER]:
        file = kept / f"{strips}_{stretch:g}_{mesh:g}.nc"
        changes = [f"cut.strips={strips}", f"mesh.size={mesh}"]
        sheet = bilayer.read_specimen(SPECIMEN, changes).with_milestones([stretch])
        finer = mesh != 0.006
        if finer and before is None:
            before = bilayer.open_result(kept / f"{strips}_{stretch:g}_0.006.nc")
        found = search(sheet, file, FEW if finer else starts, 0 if finer else random, before)
        if finer:
            before = found
        yield strips, stretch, mesh, found


def rows_of(strips: int, stretch: float, mesh: float, found: xr.Dataset) -> list[Row]:
    """Return a row for each state of a search."""
    energy = found["energy"].sum("term").values
    starts, random = found.sizes["start"], random_starts(found)
    names = ("quality", "height", "times_found", "self_contact_gap")
    return [
        Row(strips, stretch, mesh, starts, random, float(energy[k]), float(quality),
            float(height), int(times), float(gap))
        for k, (quality, height, times, gap) in enumerate(
            zip(*(found[name].values for name in names), strict=True)
        )
    ]  # fmt: skip


def table(rows: Sequence[Row]) -> str:
    """Return the rows as a table of a page."""
    lines = [f"{' | '.join(COLUMNS)} |", "---|" * len(COLUMNS)]
    lines += [
        f"{row.strips} | {row.prestretch:g} | {1e3 * row.mesh:g} mm | {row.starts} | "
        f"{row.random} | "
        f"{1e6 * row.energy:.2f}{' (touches)' if row.gap == 0 else ''} | {row.quality:.3f} | "
        f"{1e3 * row.height:.2f} | {row.found} |"
        for row in rows
    ]
    return "\n".join(f"| {line}" for line in lines)


def page_with(text: str, rows: Sequence[Row]) -> str:
    """Return the text of a page with the table between its marks."""
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n\n{table(rows)}\n\n{END}{rest.split(END)[1]}"


def main(words: Sequence[str] | None = None) -> int:
    """Search; write the rows and the table of the page."""
    parser = argparse.ArgumentParser(prog="scripts/known_states", description=__doc__)
    parser.add_argument("--starts", type=int, default=60, help="of each search on 6 mm")
    parser.add_argument("--random", type=int, default=200, help="of these, random ones at least")
    parser.add_argument("--kept", type=Path, default=ROOT / "results" / "known_states",
                        help="folder of the searches")  # fmt: skip
    parser.add_argument("--rows", type=Path, default=ROOT / "results" / "known_states.csv",
                        help="file of the numbers")  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "states.md",
                        help="page whose table is written")  # fmt: skip
    options = parser.parse_args(words)
    options.kept.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    try:
        for found in searched(options.kept, options.starts, options.random):
            rows += rows_of(*found)
            write_table(options.rows, rows)
    except bilayer.BilayerError as error:
        print(f"scripts/known_states: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    text = page_with(options.output.read_text(encoding="utf-8"), read_table(options.rows, Row))
    with whole_file(options.output, "page") as partial:
        partial.write_text(text, encoding="utf-8")
    print(f"{len(rows)} states with {len(fields(Row))} numbers each: {options.rows}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
