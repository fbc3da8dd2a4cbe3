"""The shell's stresses against those of the finite-element model on the paper's specimen, by layer.

Started by scripts/stresses, which sets the environment up.
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

import bilayer

IN_PLANE = ["xx", "yy", "xy"]
MILESTONES = (1.03, 1.06, 1.12, 1.24)
ANGLE_FROM = 0.1
"""Directions count where the principal stresses differ by more than this share of the rms."""


@dataclass(frozen=True)
class Row:
    """One layer at one height and milestone: rms over the faces by area, Pa and degrees."""

    prestretch: float
    layer: str
    level: str
    shell: float
    solid: float
    apart: float
    angle: float


def main(words: Sequence[str] | None = None) -> int:
    """Compute the fields of both results and write the page."""
    parser = argparse.ArgumentParser(prog="scripts/stresses", description=__doc__.splitlines()[0])
    parser.add_argument("--solid", type=Path, default=Path("results/paper/fenics.nc"))
    parser.add_argument("--shell", type=Path, default=Path("results/paper/shell_morley.nc"))
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/stresses.md"))
    options = parser.parse_args(words)
    solid, shell = (bilayer.open_result(path) for path in (options.solid, options.shell))
    kept = [m for m in MILESTONES if m in solid["prestretch"] and m in shell["prestretch"]]
    solid, shell = (result.sel(prestretch=kept) for result in (solid, shell))
    mesh = bilayer.result_mesh(solid)
    if not mesh.same_as(bilayer.result_mesh(shell)):
        print("the results are on different meshes, expected one", file=sys.stderr)
        return 2
    found = [bilayer.fields(result) for result in (solid, shell)]
    options.output.write_text(page(list(rows(*found, mesh.areas)), len(mesh.triangles)))
    return 0


def rows(solid: xr.Dataset, shell: xr.Dataset, areas: np.ndarray) -> Iterator[Row]:
    """Yield a row for each milestone, layer and height."""
    both = [fields["cauchy_stress"].sel(component=IN_PLANE) for fields in (solid, shell)]
    for stretch in solid["prestretch"].values:
        for layer in solid["sheet_layer"].values:
            for level in solid["level"].values:
                at = {"prestretch": stretch, "sheet_layer": layer, "level": level}
                s, h = (stress.sel(at).values for stress in both)
                yield Row(
                    float(stretch), str(layer), str(level),
                    rms(h, areas), rms(s, areas), rms(h - s, areas), angle(s, h),
                )  # fmt: skip


def rms(stress: np.ndarray, areas: np.ndarray) -> float:
    """Return the rms of the tensor's norm over the faces that have one, Pa."""
    square = (stress**2) @ [1, 1, 2]
    known = np.isfinite(square)
    return float(np.sqrt(np.average(square[known], weights=areas[known])))


def angle(solid: np.ndarray, shell: np.ndarray) -> float:
    """Return the median angle between the first principal axes in the plane, degrees."""
    axes = [0.5 * np.arctan2(2 * s[:, 2], s[:, 0] - s[:, 1]) for s in (solid, shell)]
    apart = np.abs((axes[0] - axes[1] + np.pi / 2) % np.pi - np.pi / 2)
    gap = np.hypot(solid[:, 0] - solid[:, 1], 2 * solid[:, 2])
    told = gap > ANGLE_FROM * np.sqrt(np.nanmean(solid**2))
    return float(np.degrees(np.median(apart[told])))


def page(rows: Sequence[Row], triangles: int) -> str:
    """Return the page of the numbers."""
    lines = [
        f"| {row.prestretch:g} | {row.layer} | {row.level} | {row.solid / 1e3:.2f} "
        f"| {row.shell / 1e3:.2f} | {row.apart / 1e3:.2f} | {100 * row.apart / row.solid:.0f} % "
        f"| {row.angle:.1f} |"
        for row in rows
    ]
    return PAGE.format(
        triangles=triangles,
        middle=_range(row.apart / row.solid for row in rows if row.level == "middle"),
        faces=_range(row.apart / row.solid for row in rows if row.level != "middle"),
        lines="\n".join(lines),
    )


def _range(shares: Iterable[float]) -> str:
    percent = [100 * share for share in shares]
    return f"{min(percent):.0f} to {max(percent):.0f} %"


PAGE = """\
# Stresses: the shell against the finite-element model

This page is written by `scripts/stresses` from the two results of the paper's specimen in
`results/paper` ({triangles} triangles). [fields.md](fields.md) says what is compared: the Cauchy
stress in the plane of the sheet, in axes that turn with the material, at the bottom, the middle and
the top of each layer, over the centroid of each triangle. *apart* is the rms over the faces of the
difference, in kPa and over that of the finite-element model. The last column is the median angle
between the first principal axes, where the two principal stresses are apart.

In the middle of the layers the models are {middle} apart, at their faces {faces}.
The finite-element model has one element through each layer. Near the rim and the cuts, over about
a thickness, its stress is three-dimensional; the shell's is not.

| prestretch | layer | height | FE, kPa | shell, kPa | apart, kPa | apart | angle, ° |
|---|---|---|---|---|---|---|---|
{lines}
"""


if __name__ == "__main__":
    sys.exit(main())
