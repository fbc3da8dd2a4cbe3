"""The two solvers against each other on sheets of other outlines and patterns, thin and thick.

Started by scripts/any_sheet, which sets the environment up.
"""

import argparse
import csv
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

import bilayer
from bilayer import (
    Cross,
    CutPattern,
    Disc,
    Ellipse,
    Layer,
    MeshSize,
    MooneyRivlin,
    Prestretch,
    Rectangle,
    Response,
    Specimen,
)
from bilayer.results.comparison import compare
from bilayer.specimen.pattern import Pattern

STRETCHED = MooneyRivlin(22060.0, 1656.0, 1e-5)
CUT = MooneyRivlin(17880.0, 84450.0, 1e-5)
THICKNESS = {"substrate": 1.1e-3, "kirigami": 1.6e-3}
"""Natural, of the bistable sheets that the constants are published for, m."""

SHEETS = {
    "square": (Rectangle(0.04, 0.04), None, 2.5e-3),
    "ellipse": (Ellipse(0.056, 0.028), None, 2.5e-3),
    "cross on a square": (Rectangle(0.04, 0.04), Cross(3.3e-3), 2e-3),
    "lotus of 10 petals": (
        Disc(0.02),
        CutPattern(10, 0.55 * 0.02, 0.4 * 2 * np.pi / 10),
        2.5e-3,
    ),
}
"""Outline, pattern of the kirigami and mesh size, m."""
PILES = {"bilayer": ("substrate", "kirigami"), "trilayer": ("lower", "substrate", "upper")}
SHARES = (0.05, 0.1, 0.2, 0.02)
"""Thicknesses of all layers together, over the characteristic length."""
FULL_SIZE = 0.04
"""Sheets that are thinner than this have a finer mesh in proportion, as they bend more."""
MILESTONES, FARTHEST = (1.03, 1.06), 1.2
FLAT = 1e-6
"""Height of a shape that is flat, over the characteristic length."""
THIN, TOLERANCE = 0.05, 0.005
"""Up to this thickness and up to the last of the milestones the solvers must agree so well."""


@dataclass(frozen=True)
class Row:
    """What one milestone of one sheet came to.

    Lengths are over the characteristic length; what was not reached is NaN.
    """

    sheet: str
    pile: str
    thickness: float
    is_published: int
    prestretch: float
    triangles: int
    distance: float
    height_fenics: float
    height_shell: float
    energy_ratio: float
    unstable_fenics: int
    unstable_shell: int
    gap: float
    seconds: float


def specimen_of(sheet: str, pile: str, share: float | None) -> Specimen:
    """Return a sheet whose layers are so thick together, or as published (None)."""
    outline, pattern, size = SHEETS[sheet]
    layers = [_layer(name, pattern) for name in PILES[pile]]
    if share is not None:
        scale = share * outline.characteristic_length / sum(layer.thickness for layer in layers)
        layers = [replace(layer, thickness=scale * layer.thickness) for layer in layers]
        size *= min(1.0, share / FULL_SIZE)
    milestones = [*MILESTONES, FARTHEST] if share is None else MILESTONES
    return Specimen(outline, layers, Prestretch(milestones), MeshSize(size), name=sheet)


def _layer(name: str, pattern: Pattern | None) -> Layer:
    if name == "substrate":
        return Layer(name, THICKNESS[name], STRETCHED, response=Response("path"))
    return Layer(name, THICKNESS["kirigami"], CUT, pattern=pattern)


def rows_of(sheet: str, pile: str, share: float | None) -> Iterator[Row]:
    """Solve a sheet by both solvers on one mesh, the shell's shapes leading the FE model's."""
    specimen = specimen_of(sheet, pile, share)
    mesh = bilayer.generate_mesh(specimen)
    begun = time.process_time()
    shell = bilayer.solve(specimen, "dshell", mesh=mesh)
    solid = bilayer.solve(specimen, "fenics", mesh=mesh)
    seconds = time.process_time() - begun
    against = compare(solid, shell)
    length = specimen.characteristic_length
    energy = [_energy(result) for result in (solid, shell)]
    for k, stretch in enumerate(specimen.prestretch.nominal):
        yield Row(
            sheet,
            pile,
            sum(layer.thickness for layer in specimen.layers) / length,
            int(share is None),
            stretch,
            len(mesh.triangles),
            float(against["rms_distance"][k]) / length,
            float(solid["height"][k]) / length,
            float(shell["height"][k]) / length,
            float(energy[0][k] / energy[1][k]),
            int(solid["unstable_modes"][k]),
            int(shell["unstable_modes"][k]),
            float(solid["self_contact_gap"][k]) / length,
            seconds,
        )


def _energy(result: xr.Dataset) -> NDArray[np.float64]:
    return np.asarray(result["energy"].sum("term", skipna=False).values)


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a file, none if it is not there."""
    if not path.exists():
        return []
    kinds = {field.name: field.type for field in fields(Row)}
    with path.open() as file:
        return [
            Row(**{name: kinds[name](text) for name, text in row.items()})
            for row in csv.DictReader(file)
        ]


def write_rows(path: Path, rows: Sequence[Row]) -> None:
    """Write all rows."""
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Row)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)


def cases() -> Iterator[tuple[str, str, float | None]]:
    """Yield sheet, pile and thickness of all cases, those as published first."""
    for share in (None, *SHARES):
        for sheet in SHEETS:
            for pile in PILES:
                yield sheet, pile, share


def is_done(rows: Sequence[Row], sheet: str, pile: str, share: float | None) -> bool:
    """Return whether there are rows of a case."""
    return any(
        (row.sheet, row.pile) == (sheet, pile)
        and row.is_published == (share is None)
        and (share is None or abs(row.thickness - share) < 1e-9)
        for row in rows
    )


def misses(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of thin sheets that the solvers do not agree on."""
    judged = [row for row in rows if row.thickness <= THIN + 1e-9 and row.prestretch < FARTHEST]
    return [row for row in judged if not row.distance <= TOLERANCE]


def main(words: Sequence[str] | None = None) -> int:
    """Compute what is missing of the rows, write the page; 1 if the solvers disagree."""
    parser = argparse.ArgumentParser(
        prog="scripts/any_sheet", description="The two solvers on other sheets, thin and thick."
    )
    parser.add_argument("--rows", type=Path, default=Path("results/any_sheet.csv"),
                        help="file of the numbers, which are not computed again")  # fmt: skip
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/any_sheet.md"),
                        help="the page that is written of them")  # fmt: skip
    options = parser.parse_args(words)
    rows = read_rows(options.rows)
    for case in cases():
        if is_done(rows, *case):
            continue
        try:
            found = list(rows_of(*case))
        except bilayer.ComputationError as error:
            print(f"{case}: {error}", file=sys.stderr)
            continue
        rows += found
        write_rows(options.rows, rows)
        for row in found:
            print(f"{row.sheet}, {row.pile}, {row.thickness:.1%}, {row.prestretch:g}: "
                  f"{row.distance:.2%} apart", file=sys.stderr, flush=True)  # fmt: skip
    options.output.write_text(page(rows))
    missed = misses(rows)
    for row in missed:
        print(f"missed: {row}", file=sys.stderr)
    return 1 if missed else 0


INTRODUCTION = """\
# Sheets of any outline: the shell against the finite-element model

This page is written by `scripts/any_sheet`, which computes every number anew that is not in
`results/any_sheet.csv`. Both solvers take the same planar mesh, and the shell's shapes lead the
finite-element model. The distance is the rms distance of the reference surfaces after alignment,
over the sheet's characteristic length L, the radius of the circle of its area.

Material and thicknesses are those published for bistable kirigami sheets: substrate C10 22.06 kPa,
C01 1.656 kPa, 1.1 mm, stretched; kirigami 17.88 and 84.45 kPa, 1.6 mm; D1 1e-5 1/Pa. A bilayer
is a substrate with one kirigami layer on it, a trilayer has one on either side. For other
thicknesses, all layers are scaled alike. The thickness is that of all layers together before they
are stretched, over L. The meshes have edges of 2 and 2.5 mm, thinner sheets than 4 % of L finer
ones in proportion.

| sheet | outline | kirigami |
| --- | --- | --- |
| square | 40 mm | whole |
| ellipse | 56 x 28 mm | whole |
| cross on a square | 40 mm | two bars of 3.3 mm from rim to rim |
| lotus of 10 petals | disc of 20 mm | ten cutouts from 11 mm on, 40 % of the ring |
"""


def page(rows: Sequence[Row]) -> str:
    """Return the page of all rows."""
    scaled = [row for row in rows if not row.is_published]
    published = [row for row in rows if row.is_published]
    missed = misses(rows)
    judged = len(
        [row for row in rows if row.thickness <= THIN + 1e-9 and row.prestretch < FARTHEST]
    )
    verdict = (
        f"Up to a thickness of {100 * THIN:.0f} % of L and a prestretch of {max(MILESTONES):g} the "
        f"solvers must be within\n{100 * TOLERANCE:.1f} % of L: "
        f"{judged - len(missed)} of {judged} shapes are."
    )
    parts = [INTRODUCTION, "## Thin sheets", verdict, *(_miss(row) for row in missed)]
    for stretch in MILESTONES:
        parts += [
            f"## Distance by thickness, prestretch {stretch:g}",
            _largest([row for row in scaled if row.prestretch == stretch]),
            "Over L:",
            _by_thickness(scaled, stretch, _distance),
            "Over the height of the shape:",
            _by_thickness(scaled, stretch, _distance_over_height),
        ]
    parts += ["## As published", _as_published(published)]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _largest(rows: Sequence[Row]) -> str:
    known = [row for row in rows if np.isfinite(row.distance)]
    bent = [row for row in known if row.height_fenics > FLAT]
    far = max(known, key=lambda row: row.distance)
    steep = max(bent, key=lambda row: row.distance / row.height_fenics)
    return (
        f"At most {_percent(far.distance)} of L ({far.sheet}, {far.pile}, {far.thickness:.0%}) and "
        f"{_percent(steep.distance / steep.height_fenics)} of the height\n({steep.sheet}, "
        f"{steep.pile}, {steep.thickness:.0%})."
    )


def _miss(row: Row) -> str:
    return (
        f"- {row.sheet}, {row.pile}, thickness {row.thickness:.0%}, prestretch {row.prestretch:g}: "
        f"{row.distance:.2%}"
    )


def _by_thickness(rows: Sequence[Row], stretch: float, cell: Callable[[Row], str]) -> str:
    thicknesses = sorted({round(row.thickness, 9) for row in rows})
    heading = ["sheet", "layers", *(f"{thickness:.0%}" for thickness in thicknesses)]
    lines = [heading, ["---"] * len(heading)]
    for sheet in SHEETS:
        for pile in PILES:
            found = {
                round(row.thickness, 9): cell(row)
                for row in rows
                if (row.sheet, row.pile, row.prestretch) == (sheet, pile, stretch)
            }
            cells = [found.get(thickness, "-") for thickness in thicknesses]
            lines.append([sheet, pile, *cells])
    return _table(lines)


def _distance(row: Row) -> str:
    return _percent(row.distance) + "".join(mark for mark, holds in _marks(row) if holds)


def _distance_over_height(row: Row) -> str:
    if row.height_fenics < FLAT:
        return "flat"
    return _percent(row.distance / row.height_fenics)


def _percent(share: float) -> str:
    return "-" if np.isnan(share) else f"{100 * share:.2f} %"


def _marks(row: Row) -> tuple[tuple[str, bool], ...]:
    return (" (unstable)", row.unstable_fenics > 0 or row.unstable_shell > 0), (
        " (touches itself)",
        row.gap == 0,
    )


def _as_published(rows: Sequence[Row]) -> str:
    heading = ["sheet", "layers", "thickness", "prestretch", "distance", "height FE", "shell",
               "energy FE / shell"]  # fmt: skip
    lines = [heading, ["---"] * len(heading)]
    lines += [
        [row.sheet, row.pile, f"{row.thickness:.1%}", f"{row.prestretch:g}", _distance(row),
         _number(row.height_fenics), _number(row.height_shell), _number(row.energy_ratio)]
        for row in rows
    ]  # fmt: skip
    return f"{_table(lines)}\n\nHeights are over L."


def _number(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.3f}"


def _table(lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


if __name__ == "__main__":
    sys.exit(main())
