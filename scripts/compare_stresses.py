"""The shell's stresses against those of the finite-element model on the paper's specimen, by layer.

Started by scripts/stresses, which sets the environment up.
"""

import argparse
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr

import bilayer

IN_PLANE = ["xx", "yy", "xy"]
MILESTONES = (1.03, 1.06, 1.12, 1.24)
MESH_STRETCH = 1.06
MESHES = ((0.006, 1), (0.004, 1), (0.004, 2), (0.0025, 1))
"""Sizes, m, and elements through each layer of the finite-element model."""
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
    inside: float
    """The rms of the difference over that of the finite-element model, away from the edges."""


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
    is_inside = away_from_edges(mesh, bilayer.result_specimen(solid))
    found = compared(solid, shell)
    share = float(mesh.areas[is_inside].sum() / mesh.areas.sum())
    text = page(found, len(mesh.triangles), share, list(on_other_meshes()))
    options.output.write_text(text)
    return 0


def compared(solid: xr.Dataset, shell: xr.Dataset) -> list[Row]:
    """Return the rows of two results on one mesh."""
    mesh, of_both = bilayer.result_mesh(solid), [bilayer.fields(each) for each in (solid, shell)]
    is_inside = away_from_edges(mesh, bilayer.result_specimen(solid))
    return list(rows(of_both[0], of_both[1], mesh.areas, is_inside))


def on_other_meshes() -> Iterator[tuple[str, list[Row]]]:
    """Yield what is solved anew at one prestretch, in words, and its rows."""
    for size, elements in MESHES:
        sheet = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(size))
        sheet = sheet.with_milestones([MESH_STRETCH])
        mesh = bilayer.generate_mesh(sheet)
        settings = bilayer.SolidSettings(substrate_elements=elements, kirigami_elements=elements)
        solid = bilayer.solve(sheet, "fenics", settings, mesh=mesh)
        shell = bilayer.solve(sheet, "dshell", mesh=mesh)
        yield f"{1e3 * size:g} mm, {elements} through each layer", compared(solid, shell)


def away_from_edges(mesh: bilayer.PlanarMesh, specimen: bilayer.Specimen) -> np.ndarray:
    """Return which triangles are farther from all edges than the layers are thick together."""
    thickness = sum(layer.thickness for layer in specimen.layers)
    return edge_distances(mesh, specimen.layer_names) > thickness


def edge_distances(mesh: bilayer.PlanarMesh, names: Iterable[str]) -> np.ndarray:
    """Return how far the centroid of each triangle is from rim, cuts and the layers' edges, m."""
    parts = [np.arange(len(mesh.triangles)), *(mesh.faces_of(name) for name in names)]
    edges = np.concatenate([mesh.edges_of(part) for part in parts])
    a, b = np.moveaxis(mesh.points[edges], 1, 0)
    centroids = mesh.points[mesh.triangles].mean(axis=1)[:, None]
    share = ((centroids - a) * (b - a)).sum(axis=2) / ((b - a) ** 2).sum(axis=1)
    nearest = a + np.clip(share, 0.0, 1.0)[..., None] * (b - a)
    return np.linalg.norm(centroids - nearest, axis=2).min(axis=1)


def rows(
    solid: xr.Dataset, shell: xr.Dataset, areas: np.ndarray, is_inside: np.ndarray
) -> Iterator[Row]:
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
                    rms((h - s)[is_inside], areas[is_inside])
                    / rms(s[is_inside], areas[is_inside]),
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


def page(
    rows: Sequence[Row], triangles: int, share: float, meshes: Sequence[tuple[str, list[Row]]]
) -> str:
    """Return the page of the numbers."""
    lines = [
        f"| {row.prestretch:g} | {row.layer} | {row.level} | {row.solid / 1e3:.2f} "
        f"| {row.shell / 1e3:.2f} | {row.apart / 1e3:.2f} | {100 * row.apart / row.solid:.0f} % "
        f"| {100 * row.inside:.0f} % | {row.angle:.1f} |"
        for row in rows
    ]
    return PAGE.format(
        triangles=triangles,
        stretch=MESH_STRETCH,
        meshes="\n".join(_mesh_line(name, found) for name, found in meshes),
        share=100 * share,
        middle_inside=_range(row.inside for row in rows if row.level == "middle"),
        faces_inside=_range(row.inside for row in rows if row.level != "middle"),
        middle=_range(row.apart / row.solid for row in rows if row.level == "middle"),
        faces=_range(row.apart / row.solid for row in rows if row.level != "middle"),
        lines="\n".join(lines),
    )


def _mesh_line(name: str, rows: Sequence[Row]) -> str:
    """Return a row of the table of meshes: the middle of each layer, then all of its faces."""
    cells = []
    for layer in dict.fromkeys(row.layer for row in rows):
        for is_middle in (True, False):
            chosen = [r for r in rows if r.layer == layer and (r.level == "middle") == is_middle]
            whole = np.mean([row.apart / row.solid for row in chosen])
            inside = np.mean([row.inside for row in chosen])
            cells.append(f"{100 * whole:.0f} %, {100 * inside:.0f} %")
    return f"| {name} | {' | '.join(cells)} |"


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
a thickness, its stress is three-dimensional; the shell's is not. The column *inside* leaves out the
triangles whose centroid is nearer to the rim or a cut than the thickness of all layers.
{share:.0f} % of the sheet's area stay. There the models are {middle_inside} apart in the middle,
and {faces_inside} at the faces.

| prestretch | layer | height | FE, kPa | shell, kPa | apart, kPa | apart | inside | angle, ° |
|---|---|---|---|---|---|---|---|---|
{lines}

## How much of it is the mesh

At {stretch:g}, on meshes made for it: *apart* as above, then *inside*, of the middle of a layer and
as a mean of its two faces.

| mesh | substrate, middle | its faces | kirigami, middle | its faces |
|---|---|---|---|---|
{meshes}
"""


if __name__ == "__main__":
    sys.exit(main())
