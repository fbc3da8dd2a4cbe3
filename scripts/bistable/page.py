"""The page of the published bistable sheets."""

import math
from collections.abc import Iterable, Sequence

from bistable.cases import MILESTONES, PUBLISHED
from bistable.rows import FLAT, STARTS, Point, Row, bent_from

INTRODUCTION = """# Published bistable sheets

This page and its figure are written by `scripts/bistable_sheets`, which computes every number anew
that is not in `results/bistable_sheets.csv` and `results/bistable_paths.csv`.

Two sheets were published as snapping between two domes: a lotus of 10 petals on a disc of 20 mm in
radius (cutouts from 0.55 of the radius on, 40 % of the ring removed;
[`examples/trilayer_lotus.toml`](../examples/trilayer_lotus.toml)), and a cross with arms of 3.3 mm
on a square of 40 mm ([`examples/square_cross.toml`](../examples/square_cross.toml), on both sides).
A stretched substrate lies between two like outer layers. Its constants are the published ones:
substrate C10 22.06 kPa, C01 1.656 kPa, 1.1 mm / lambda^2 thick; outer layers 17.88 kPa and 84.45
kPa, 1.6 mm; D1 1e-5 1/Pa.

Turned over, such a sheet is itself. So it is flat, or each bent state has a mirror state. The outer
layers are also taken a quarter as thick.

![Heights of the bent states over the prestretch](images/bistable_sheets.png)

Lines and dots are the shell's, crosses the finite-element model's.
"""

FROM_WHEN = """
## From which prestretch on

A bent state is followed down from {top:g} in steps of 0.01, by the shell. Its height goes to zero
like the square root of what the prestretch is beyond the threshold.
"""

TABLE = """
## States and barriers

By the shell, from {starts} starts or more for each line. `mirror` is the relative difference of the
energies of the two mirror states, `barrier` the energy from one up to the pass to the other, which
is computed at {published:g}. The pass is a flat or a bent shape; "no pass" says that none with one
unstable mode was found.
"""

SOLID = """
## The finite-element model at {published:g}

It starts from the shell's lowest state and from its mirror state, on the same planar mesh. `mirror`
is the relative difference of its two energies.
"""

LIMITS = """
## What this says

{verdicts}

The published thickness, with both outer layers, is {share:.2g} of the radius. Beyond 0.1 a shell
is only a first answer ([any_sheet.md](any_sheet.md)), so the finite-element model counts there. By
both the published lotus stays flat with these numbers.

Thresholds and barriers depend on the mesh, which is of 3 mm (lotus) and 3.75 mm, 1.5 mm at the
corners (cross). `--mesh-scale` computes others.

[states.md](states.md#the-barrier-between-two-states) has barriers by the finite-element model, and
the force of an indenter, of thinner sheets.
"""


def page(rows: Sequence[Row], points: Sequence[Point]) -> str:
    """Return the text of the page."""
    ordered = sorted(rows, key=lambda row: (row.sheet, -row.outer, row.prestretch))
    published = [row for row in ordered if row.prestretch == PUBLISHED]
    thickest = max(row.outer for row in rows)
    return "".join([
        INTRODUCTION,
        FROM_WHEN.format(top=max(MILESTONES)),
        _table(_threshold_columns(points)),
        TABLE.format(starts=STARTS, published=PUBLISHED),
        _table([_state_columns(row) for row in ordered]),
        SOLID.format(published=PUBLISHED),
        _table([_solid_columns(row) for row in published]),
        LIMITS.format(
            verdicts="\n".join(_verdicts(published)), share=(2 * thickest + 1.1e-3) / 20e-3
        ),
    ])  # fmt: skip


def _threshold_columns(points: Sequence[Point]) -> list[dict[str, str]]:
    sheets = sorted({(point.sheet, -point.outer) for point in points})
    lines = []
    for sheet, outer in sheets:
        path = [point for point in points if (point.sheet, -point.outer) == (sheet, outer)]
        value = bent_from(path)
        words = f"none up to {max(MILESTONES):g}" if math.isnan(value) else f"{value:.3f}"
        lines.append({"sheet": sheet, "outer layers, mm": _mm(-outer), "bent from": words})
    return lines


def _state_columns(row: Row) -> dict[str, str]:
    return {
        "sheet": row.sheet,
        "outer layers, mm": _mm(row.outer),
        "prestretch": f"{row.prestretch:g}",
        "verdict": row.verdict,
        "symmetry": row.symmetry,
        "height, mm": _mm(row.height),
        "energy, mJ": f"{1e3 * row.energy:.5f}",
        "mirror": "-" if math.isnan(row.mirror) else f"{row.mirror:.0e}",
        "barrier, µJ": "-" if math.isnan(row.barrier) else f"{1e6 * row.barrier:.3g}, {_pass(row)}",
    }


def _solid_columns(row: Row) -> dict[str, str]:
    return {
        "sheet": row.sheet,
        "outer layers, mm": _mm(row.outer),
        "unstable modes": str(row.solid_modes) if row.solid_modes >= 0 else "not reached",
        "height, mm": _number(1e3 * row.solid_height, "{:.2f}"),
        "of the shell": _mm(row.height),
        "mirror": _number(row.solid_mirror, "{:.0e}"),
    }


def _pass(row: Row) -> str:
    """Say what the pass is."""
    if row.saddle_modes != 1:
        return "no pass"
    return "flat" if row.saddle_height < FLAT else "bent"


def _verdicts(published: Iterable[Row]) -> Iterable[str]:
    for row in published:
        solid = (
            "not reached" if row.solid_modes < 0
            else "flat" if row.solid_height < FLAT
            else f"bent, {1e3 * row.solid_height:.2f} mm"
        )  # fmt: skip
        yield (
            f"- {row.sheet}, outer layers {_mm(row.outer)} mm: {row.verdict} by the shell; the "
            f"finite-element model is {solid}"
        )


def _mm(length: float) -> str:
    return f"{1e3 * length:.2f}"


def _number(value: float, form: str) -> str:
    return "-" if math.isnan(value) else form.format(value)


def _table(lines: Sequence[dict[str, str]]) -> str:
    names = list(lines[0])
    rows = [names, ["---"] * len(names), *(list(line.values()) for line in lines)]
    return "\n" + "\n".join(f"| {' | '.join(row)} |" for row in rows) + "\n"
