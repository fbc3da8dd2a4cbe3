"""Whether the default result is the lowest known state, for each specimen of the maps, as a page.

Started by scripts/map_states, which sets the environment up. A row that is in the file of the
numbers is not computed again.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from fe_maps import MapCase, map_cases
from sheet_comparison.table import read_table, write_table

import bilayer
from bilayer.landscape.lower import own_state, states_beside
from bilayer.runtime.output_file import whole_file

ROOT = Path(__file__).parents[1]
PATH = (1.03, 1.06, 1.09, 1.12, 1.15)
"""Milestones of the default result; it is judged at the second and the last."""
JUDGED = (1, 4)
SAME_ENERGY = 1e-6
"""Relative, of one state after two ways."""

HEAD = """# The default result on the maps, and the lowest known state

`scripts/map_states` writes this page. Each row is the paper's specimen with one field changed, on a
planar mesh of 6 mm, by the accurate shell with its default settings, at the end of the load path
1.03, 1.06, 1.09, 1.12, 1.15 or at 1.06 on it. From there a search looks for other states by
{starts} starts ([states.md](states.md)). `lower_state` is what `bilayer solve --look-below
{starts}` writes into the result: the energy of the lowest state over that of the result, less 1. It
is 0 where the default result is the lowest state that is known.

- {lowest} of {count} default results are the lowest known state.
- The others are {least:.2%} to {most:.2%} above it, and their `lower_state` says so.
"""


@dataclass(frozen=True)
class Row:
    """A default result: energies in J, and how many starts have looked for others."""

    case: str
    prestretch: float
    starts: int
    states: int
    energy: float
    lowest: float

    @property
    def lower_state(self) -> float:
        """See `bilayer.look_below`; 0 within round-off of two ways to one state."""
        below = self.lowest / self.energy - 1
        return below if below < -SAME_ENERGY else 0.0


def rows_of(case: MapCase, starts: int) -> Iterator[Row]:
    """Return the rows of a specimen."""
    result = bilayer.solve(case.specimen.with_milestones(PATH), "dshell")
    for place in JUDGED:
        found = states_beside(result.isel(prestretch=[place]), place, None, starts)
        if found is None:
            raise bilayer.ComputationError(f"{case.name}: the default result leads to no state")
        energy = found["energy"].sum("term").values
        own = float(energy[own_state(found)])
        yield Row(case.name, PATH[place], starts, len(energy), own, float(energy.min()))


def page(rows: Sequence[Row]) -> str:
    """Return the page."""
    below = [-row.lower_state for row in rows if row.lower_state < 0]
    head = HEAD.format(
        starts=rows[0].starts,
        count=len(rows),
        lowest=len(rows) - len(below),
        least=min(below, default=0.0),
        most=max(below, default=0.0),
    )
    lines = [
        "| specimen | prestretch | states | energy of the default result, µJ | lowest known, µJ | "
        "`lower_state` |",
        "|---|---|---|---|---|---|",
        *(
            f"| {row.case} | {row.prestretch:g} | {row.states} | {1e6 * row.energy:.2f} | "
            f"{1e6 * row.lowest:.2f} | {row.lower_state:.5f} |"
            for row in rows
        ),
    ]
    return head + "\n" + "\n".join(lines) + "\n"


def main(words: Sequence[str] | None = None) -> int:
    """Compute what is missing; write the numbers and the page."""
    parser = argparse.ArgumentParser(prog="scripts/map_states", description=__doc__)
    parser.add_argument("--starts", type=int, default=12, help="of each search")
    parser.add_argument("--rows", type=Path, default=ROOT / "results" / "map_states.csv",
                        help="file of the numbers")  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, default=ROOT / "docs" / "map_states.md",
                        help="page")  # fmt: skip
    options = parser.parse_args(words)
    rows = read_table(options.rows, Row)
    try:
        for case in map_cases():
            if any((row.case, row.starts) == (case.name, options.starts) for row in rows):
                continue
            rows = [row for row in rows if row.case != case.name]
            rows += rows_of(case, options.starts)
            write_table(options.rows, rows)
            print(f"{case.name}: {[row.lower_state for row in rows[-len(JUDGED) :]]}", flush=True)
    except bilayer.BilayerError as error:
        print(f"scripts/map_states: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    with whole_file(options.output, "page") as partial:
        partial.write_text(page(rows), encoding="utf-8")
    print(f"{len(rows)} rows: {options.output}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
