"""Sensitivity: the change of the quality for 1 % of each parameter of a specimen.

Central differences on one mesh topology: the planar mesh of the specimen is scaled along with the
outer radius and morphed along with the inner radius and the cutout angle, so that no remeshing
enters. The last column is the noise of remeshing, for comparison: the largest change of the
quality between the mesh and one 1 % finer.

    scripts/env python3 scripts/studies/sensitivity.py [SPECIMEN.toml] [--mesh-size 0.006]
"""

import argparse
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import bilayer
from bilayer.specimen.specimen import Specimen

STEP = 0.01
"""Relative change of each parameter, upward and downward."""


def main() -> int:
    options = _options()
    specimen = (
        bilayer.paper_specimen()
        if options.specimen is None
        else bilayer.read_specimen(options.specimen)
    )
    specimen = replace(specimen, mesh=bilayer.MeshSize(options.mesh_size))
    if options.prestretch:
        specimen = specimen.with_milestones(options.prestretch)
    print(sensitivity(specimen, options.solver).to_string(float_format=lambda v: f"{v:+.4f}"))
    return 0


def sensitivity(specimen: Specimen, solver: str) -> pd.DataFrame:
    """Return the change of the quality per 1 % of each parameter, a column per prestretch."""
    mesh = bilayer.generate_mesh(specimen)
    rows = {}
    for name, changed in parameters(specimen).items():
        up, down = (
            bilayer.solve(other, solver, mesh=morphed(mesh, specimen, other))["quality"].values
            for other in (changed(1 + STEP), changed(1 - STEP))
        )
        rows[name] = (up - down) / 2
        print(f"{name} done", file=sys.stderr)
    finer = replace(specimen, mesh=bilayer.MeshSize(specimen.mesh.size * (1 - STEP)))
    here, there = (bilayer.solve(s, solver)["quality"].values for s in (specimen, finer))
    rows["(remeshed, 1 % finer)"] = there - here
    table = pd.DataFrame(rows, index=[f"{stretch:g}" for stretch in specimen.prestretch.nominal]).T
    table.columns.name = "quality per 1 %"
    return table


def parameters(specimen: Specimen) -> dict[str, Callable[[float], Specimen]]:
    """Return for each parameter what changes it by a factor."""

    def of_layer(name: str, change: Callable[[bilayer.Layer, float], Any]):
        changed = partial(change, specimen.layer(name))
        return lambda factor: specimen.with_layer(name, **changed(factor))

    def thicker(layer: bilayer.Layer, factor: float) -> dict[str, Any]:
        return {"thickness": factor * layer.thickness}

    def stiffer(layer: bilayer.Layer, factor: float) -> dict[str, Any]:
        return {"material": _stiffer(layer.material, factor)}

    found: dict[str, Callable[[float], Specimen]] = {
        "specimen.outer_radius": lambda f: replace(
            specimen, outline=bilayer.Disc(f * specimen.characteristic_length)
        ),
        "substrate.thickness": of_layer("substrate", thicker),
        "kirigami.thickness": of_layer("kirigami", thicker),
        "substrate.young_modulus": of_layer("substrate", stiffer),
        "kirigami.young_modulus": of_layer("kirigami", stiffer),
        "prestretch (lambda - 1)": lambda f: specimen.with_milestones(
            [(1 + f * (x - 1), 1 + f * (y - 1)) for x, y in specimen.prestretch.milestones]
        ),
    }
    cut = _cut(specimen)
    for key in ("inner_radius", "cutout_angle") if cut is not None else ():
        found[f"cut.{key}"] = lambda f, key=key: specimen.with_layer(
            "kirigami", pattern=replace(cut, **{key: f * getattr(cut, key)})
        )
    return found


def morphed(mesh: bilayer.PlanarMesh, specimen: Specimen, other: Specimen) -> bilayer.PlanarMesh:
    """Return the mesh moved from one specimen's cuts to another's, piecewise linear in r and angle.

    Both have the same number of strips. The radii of rim and cutouts, and the angles of the cuts,
    map onto one another.
    """
    x, y = mesh.points.T
    radius = np.interp(np.hypot(x, y), _radii(specimen), _radii(other))
    angle = np.arctan2(y, x) % (2 * np.pi)
    if _cut(specimen) is not None:
        angle = np.interp(angle, _cut_angles(specimen), _cut_angles(other))
    points = np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])
    return bilayer.PlanarMesh(points, mesh.triangles, mesh.region)


def _cut(specimen: Specimen) -> Any:
    return specimen.layer("kirigami").pattern


def _radii(specimen: Specimen) -> list[float]:
    inner = [] if _cut(specimen) is None else [_cut(specimen).inner_radius]
    radii = [0.0, *inner, specimen.characteristic_length]
    assert all(a < b for a, b in pairwise(radii)), "a specimen has its cutouts within its rim"
    return radii


def _cut_angles(specimen: Specimen) -> NDArray[np.float64]:
    cut = _cut(specimen)
    half = cut.cutout_angle / 2
    edges = [edge for centre in cut.cutout_centres for edge in (centre - half, centre + half)]
    return np.array([0.0, *edges, 2 * np.pi])


def _stiffer(material: bilayer.MooneyRivlin, factor: float) -> bilayer.MooneyRivlin:
    """Multiply every modulus; a compressibility (d1, 1/Pa) goes the other way."""
    powers = {"c10": 1, "c01": 1, "d1": -1, "young_modulus": 1}
    fields = {k: v * factor ** powers[k] for k, v in vars(material).items() if k in powers}
    return replace(material, **fields)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Change of the quality with 1 % of a parameter.")
    parser.add_argument("specimen", nargs="?", help="a TOML file; the paper's if left out")
    parser.add_argument("--solver", default="dshell", choices=["dshell", "fenics"])
    parser.add_argument("--mesh-size", type=float, default=0.006, metavar="M")
    parser.add_argument("--prestretch", type=float, nargs="+", metavar="L")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
