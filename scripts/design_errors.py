"""What errors of a made specimen do to its shape, by the finite-element model: a table.

Each row is a specimen of its own with one error: of the strain of the prestretch, of a layer's
thickness, of the kirigami's modulus, of all angles of its cutouts, up and down. The finite-element
model goes to the specimen's last milestone from the shell's shape, which comes from flat.
"""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr

import bilayer
from bilayer.designing.scenarios import Scenario
from bilayer.mesh.planar import PlanarMesh
from bilayer.solvers.registry import solve
from bilayer.specimen.pattern import SectorProfile

MM = 1e3
HEADS = ("error", "HD", "quality", "height (mm)", "gap (mm)", "unstable modes", "iterations")


def scenarios(specimen: bilayer.Specimen, spread: float) -> Iterator[tuple[str, Scenario]]:
    """Yield the errors, each with its words; first none."""
    yield "none", Scenario({})
    thicknesses = [f"{layer.name}.thickness" for layer in specimen.layers]
    groups = {name: [name] for name in ("prestretch", *thicknesses)}
    for layer in specimen.layers:
        if layer.pattern is not None:
            groups[f"{layer.name}.modulus"] = [f"{layer.name}.modulus"]
        if isinstance(layer.pattern, SectorProfile):
            angles = f"{layer.name}.pattern.half_angles"
            groups[angles] = [f"{angles}.{k}" for k in range(len(layer.pattern.half_angles))]
    for words, names in groups.items():
        for sign in (1, -1):
            error = sign * spread
            yield f"`{words}` {error:+.0%}", Scenario(dict.fromkeys(names, error))


def computed(specimen: bilayer.Specimen, file: Path) -> xr.Dataset:
    """Return the result of a specimen, from its file if it is there."""
    resume = file if file.exists() else None
    mesh: PlanarMesh = bilayer.generate_mesh(specimen)
    settings = bilayer.SolidSettings(first_step=0.05, largest_step=0.1)
    return solve(specimen, "fenics", settings, mesh=mesh, output=file, resume=resume)


def row(words: str, result: xr.Dataset) -> str:
    """Return a line of the table."""
    last = result.isel(prestretch=-1)
    if not bool(last["converged"]):
        return f"| {words} | not reached: {result.attrs['stop_reason']} | | | | | |"
    gap = float(last["self_contact_gap"])
    numbers = (
        f"{float(last['hemisphere_distance']):.3f}",
        f"{float(last['quality']):.3f}",
        f"{MM * float(last['height']):.1f}",
        "far" if np.isinf(gap) else f"{MM * gap:.2g}",
        f"{int(last['unstable_modes'])}",
        f"{int(last['iterations'])}",
    )
    return f"| {words} | {' | '.join(numbers)} |"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("specimen", help="a specimen file")
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder of the results")
    parser.add_argument("--spread", type=float, default=0.05, help="relative error (0.05)")
    parser.add_argument("--mesh-size", type=float, metavar="MM", help="edge length, mm")
    options = parser.parse_args()
    specimen = bilayer.read_specimen(options.specimen)
    specimen = specimen.with_milestones([specimen.prestretch.milestones[-1]])
    if options.mesh_size:
        specimen = replace(specimen, mesh=bilayer.MeshSize(options.mesh_size / MM))
    options.output.mkdir(parents=True, exist_ok=True)
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    for number, (words, scenario) in enumerate(scenarios(specimen, options.spread)):
        file = options.output / f"{number:02d}.nc"
        print(row(words, computed(scenario.specimen(specimen), file)), flush=True)


if __name__ == "__main__":
    main()
