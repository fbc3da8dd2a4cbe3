"""The page of all rows."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from sheet_comparison.branches import UNKNOWN
from sheet_comparison.cases import MILESTONES, PILES, SHEETS, THIN, TOLERANCE
from sheet_comparison.cross import (
    SIZES,
    CrossRow,
    along_path,
    height_without_mesh,
    loses_symmetry_at,
)
from sheet_comparison.rows import SOFTER, Row, on_finest_mesh
from sheet_comparison.walls import WallRow, beside, is_missed

FLAT = 1e-6
"""Height of a shape that is flat, over the characteristic length."""
MEASURES = ("height FE", "shell", "relieved", "energy FE / shell", "FE / relieved")
SOLVERS = {"fenics": "FE", "dshell": "shell", "both": "both", "neither": "neither",
           UNKNOWN: "unknown"}  # fmt: skip

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


RELIEVED = """\
At a wall where it ends, a layer bears nothing, and is relieved of its stress within about its
thickness. The shell knows of that with `solver.walls = relieved`
([theory](theory-dshell.md#walls-where-layers-end)), which is not its default. "Relieved" is that
shell, from the shape of the default one (`results/any_sheet_walls.csv`).
"""

ON_FINER_MESHES = """\
Where the solvers are farther apart, each is also started from the shape of the other; the
finite-element model takes that shape at once, by Newton's method, or not at all. Of the states that
it comes to, that of lowest energy is compared with the shell's nearest one. "State of" says who
came to it without the other's shape. "Other state" is the energy of a solver's other state over
that of this one, less 1, if it has one: the two solvers had come to different states. If the
distance is still larger, the case is repeated with 0.7 of the mesh size.
"""

SENSITIVITY = f"""\
How far the shell's shape moves, over L, if the kirigami's moduli fall by {100 * SOFTER:.0f} %. A
sheet that moves far is close to a loss of symmetry or to another soft mode. There, differences of
the solvers in energy of a few percent, which the free edges of the kirigami make, become
differences in shape.
"""


def page(rows: Sequence[Row], cross: Sequence[CrossRow], walls: Sequence[WallRow]) -> str:
    """Return the page of all rows, of the thin cross by the shell, and of the relieved shell."""
    finest = on_finest_mesh(rows)
    scaled = [row for row in finest if not row.is_published]
    judged = [row for row in finest if row.is_judged]
    missed = [row for row in judged if row.is_missed]
    relieved = partial(_relieved, walls=walls)
    parts = [INTRODUCTION, RELIEVED, "## Thin sheets", _verdict(judged, walls)]
    parts += ["\n".join(_miss(row, relieved(row)) for row in missed)]
    parts += ["### On finer meshes", ON_FINER_MESHES, _repeated(rows, walls)]
    parts += ["### Sensitivity", SENSITIVITY]
    for stretch in MILESTONES:
        parts += [f"Prestretch {stretch:g}:", _by_thickness(judged, stretch, _sensitivity)]
    parts += ["### The thin cross", *_cross(cross)]
    for stretch in MILESTONES:
        parts += [
            f"## Distance by thickness, prestretch {stretch:g}",
            _largest([row for row in scaled if row.prestretch == stretch]),
            "Over L:",
            _by_thickness(scaled, stretch, _distance),
            "Over L, relieved:",
            _by_thickness(scaled, stretch, relieved),
            "Over the height of the shape:",
            _by_thickness(scaled, stretch, _distance_over_height),
        ]
    published = [row for row in finest if row.is_published]
    parts += ["## As published", _as_published(published, walls)]
    return "\n\n".join(part.strip() for part in parts) + "\n"


def _cross(rows: Sequence[CrossRow]) -> list[str]:
    """Return what the shell says of the thin cross: its loss of symmetry, and its meshes."""
    begins = loses_symmetry_at(rows)
    path = [
        [f"{row.prestretch:g}", _number(row.height), _number(row.corners)]
        for row in along_path(rows)
    ]
    return [
        f"The cross bilayer of 2 % by the shell on {1e3 * SIZES[0]:g} mm. Its four corners lie "
        f"alike over the\nplane of the arms' ends up to a prestretch of {begins:.4f}. Then two "
        "opposite ones rise, the\nothers sink, and the square of that amplitude grows with the "
        "prestretch beyond.",
        _table([["prestretch", "height", "amplitude of the corners"], ["---"] * 3, *path]),
        "Its height over L on finer and finer meshes, and by extrapolation from the last three:",
        _cross_meshes(rows),
    ]  # fmt: skip


def _cross_meshes(rows: Sequence[CrossRow]) -> str:
    heading = ["prestretch", *(f"{1e3 * size:g} mm" for size in SIZES), "limit", "order"]
    lines = [heading, ["---"] * len(heading)]
    for stretch in MILESTONES:
        found = {row.mesh_size: row.height for row in rows if row.prestretch == stretch}
        limit, order = height_without_mesh(rows, stretch)
        heights = [f"{found[size]:.4f}" for size in SIZES]
        lines.append([f"{stretch:g}", *heights, f"{limit:.4f}", f"{order:.1f}"])
    return _table(lines)


def _verdict(judged: Sequence[Row], walls: Sequence[WallRow]) -> str:
    met = sum(not row.is_missed for row in judged)
    known = [row for row in judged if beside(row, walls) is not None]
    relieved = sum(not is_missed(row, walls) for row in known)
    return (
        f"Up to a thickness of {100 * THIN:.0f} % of L and a prestretch of {max(MILESTONES):g} the "
        f"solvers must be within\n{100 * TOLERANCE:.1f} % of L. With the default shell {met} of "
        f"{len(judged)} shapes are, with the relieved one {relieved} of {len(known)}."
    )


def _repeated(rows: Sequence[Row], walls: Sequence[WallRow]) -> str:
    """Return a table of the thin sheets that were missed on some mesh, on all of their meshes."""
    cases = {row.case for row in rows if row.is_missed or row.state != "both"}
    shown = [row for row in rows if row.is_judged and row.case in cases]
    heading = ["sheet", "layers", "thickness", "prestretch", "mesh", "distance", "relieved",
               "state of", "other state FE", "shell", *MEASURES]  # fmt: skip
    lines = [heading, ["---"] * len(heading)]
    lines += [
        [row.sheet, row.pile, f"{row.thickness:.0%}", f"{row.prestretch:g}",
         f"{1e3 * row.mesh_size:.3g} mm", _distance(row), _relieved(row, walls),
         SOLVERS[row.state], _excess(row.excess_fenics), _excess(row.excess_shell),
         *_measures(row, walls)]
        for row in sorted(shown, key=lambda row: (row.case, row.prestretch, -row.mesh_size))
    ]  # fmt: skip
    return _table(lines)


def _excess(share: float) -> str:
    return "-" if np.isnan(share) else f"{share:+.1e}"


def _sensitivity(row: Row) -> str:
    return _percent(row.sensitivity)


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


def _miss(row: Row, relieved: str) -> str:
    return (
        f"- {row.sheet}, {row.pile}, thickness {row.thickness:.0%}, prestretch {row.prestretch:g}: "
        f"{_percent(row.distance)},\n  relieved {relieved}"
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


def _relieved(row: Row, walls: Sequence[WallRow]) -> str:
    found = beside(row, walls)
    if found is None:
        return "-"
    return _percent(found.distance) + (" (unstable)" if found.unstable > 0 else "")


def _measures(row: Row, walls: Sequence[WallRow]) -> list[str]:
    """Return heights and ratios of the energies, see `MEASURES`."""
    found = beside(row, walls)
    height, ratio = (np.nan, np.nan) if found is None else (found.height, found.energy_ratio)
    heights = [row.height_fenics, row.height_shell, height]
    return [_number(value) for value in (*heights, row.energy_ratio, ratio)]


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


def _as_published(rows: Sequence[Row], walls: Sequence[WallRow]) -> str:
    heading = ["sheet", "layers", "thickness", "prestretch", "distance", "relieved", *MEASURES]
    lines = [heading, ["---"] * len(heading)]
    lines += [
        [row.sheet, row.pile, f"{row.thickness:.1%}", f"{row.prestretch:g}", _distance(row),
         _relieved(row, walls), *_measures(row, walls)]
        for row in rows
    ]  # fmt: skip
    return f"{_table(lines)}\n\nHeights are over L."


def _number(value: float) -> str:
    return "-" if np.isnan(value) else f"{value:.3f}"


def _table(lines: Sequence[Sequence[str]]) -> str:
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
