"""Convergence of the paper's specimen with the finite-element model, in plane and in thickness.

Started by scripts/converge, which sets the environment up.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

import bilayer
from fenics_model import SolidSettings

MEASURES = ("radius", "span x", "span y", "height")
TOLERANCE = 0.005
RATIO = 2**0.5
"""Of one mesh size to the next: their measures then give the order of convergence."""


def measured(result: xr.Dataset) -> NDArray[np.float64]:
    """Radius of the best sphere and the spans at each milestone, (milestones, 4), m."""
    return np.column_stack([result["sphere_radius"].values, result["span"].values])


def solved(specimen: bilayer.Specimen, elements: int) -> NDArray[np.float64]:
    """Measure the specimen with some elements through each layer, from the shell's shapes."""
    mesh = bilayer.generate_mesh(specimen)
    settings = SolidSettings(substrate_elements=elements, kirigami_elements=elements)
    shell = bilayer.solve(specimen, "dshell", mesh=mesh)
    result = bilayer.solve(specimen, "fenics", settings, mesh=mesh, start=shell)
    if not result["converged"].values.all() or result["unstable_modes"].values.any():
        raise bilayer.ComputationError(f"not every shape is stable: {result.attrs['stop_reason']}")
    print(
        f"{1e3 * specimen.mesh.size:.3g} mm, {len(mesh.triangles)} triangles, {elements} through a "
        f"layer: {int(result['iterations'].sum())} Newton steps",
        file=sys.stderr,
        flush=True,
    )
    return measured(result)


def extrapolated(values: Sequence[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Limit of three measurements on meshes of a constant ratio, coarse to fine.

    Aitken's formula, which is Richardson's extrapolation at the order that the three show; where
    they show an order below 1, or none, the last one moved on by its last change.
    """
    coarse, middle, fine = values
    with np.errstate(divide="ignore", invalid="ignore"):
        shrink = (fine - middle) / (middle - coarse)
        limit = fine + (fine - middle) * shrink / (1 - shrink)
    regular = (shrink > 0) & (shrink <= 1 / RATIO)
    return np.where(regular, limit, 2 * fine - middle)


def study(specimen: bilayer.Specimen, finest: float) -> pd.DataFrame:
    """Measure on three mesh sizes, and with two elements through each layer on the coarsest."""
    sizes = [finest * RATIO**k for k in (2, 1, 0)]
    on = [replace(specimen, mesh=bilayer.MeshSize(size)) for size in sizes]
    single = [solved(each, 1) for each in on]
    limit = extrapolated(single)
    thickness = solved(on[0], 2) - single[0]
    rows = []
    for k, stretch in enumerate(specimen.prestretch.nominal):
        for m, name in enumerate(MEASURES):
            converged = limit[k, m] + thickness[k, m]
            row: dict[str, object] = {"prestretch": f"{stretch:g}", "measure": name}
            for size, values in zip(sizes, single, strict=True):
                row[f"{1e3 * size:.2g} mm"] = f"{1e3 * values[k, m]:.3f}"
            row["in plane"] = f"{1e3 * limit[k, m]:.3f}"
            row["2 elements"] = f"{thickness[k, m] / single[0][k, m]:+.2%}"
            row["limit"] = f"{1e3 * converged:.3f}"
            for size, values in zip(sizes, single, strict=True):
                row[f"error {1e3 * size:.2g}"] = f"{values[k, m] / converged - 1:+.2%}"
            row["default"] = (
                "within" if abs(single[1][k, m] / converged - 1) <= TOLERANCE else "BEYOND"
            )
            rows.append(row)
    return pd.DataFrame(rows)


def main(words: Sequence[str] | None = None) -> int:
    options = _options(words)
    specimen = bilayer.paper_specimen().with_milestones(options.prestretch)
    try:
        table = study(specimen, options.finest)
    except bilayer.BilayerError as error:
        print(f"scripts/converge: error: {error}", file=sys.stderr)
        return 2 if isinstance(error, bilayer.InputError) else 1
    text = (
        "The paper's specimen, finite-element model, one element through each layer; mm.\n"
        "in plane: extrapolated; 2 elements: change by two through each layer, on the coarsest "
        "mesh;\nlimit: both; default: whether the middle mesh is within "
        f"{TOLERANCE:.1%} of it.\n\n" + table.to_string(index=False) + "\n"
    )
    print(text, end="")
    if options.output is not None:
        options.output.write_text(text, encoding="utf-8")
    return int((table["default"] == "BEYOND").any())


def _options(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/converge",
        description="The paper's specimen on three mesh sizes, and with two elements through each "
        "layer; minutes. Exit status 1 if the middle size is beyond 0.5 % of the limit.",
        epilog="example:\n  scripts/converge --finest 0.00283   # 5.7, 4 and 2.8 mm",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--finest", type=float, default=0.003 / RATIO, metavar="M",
        help="finest mesh size, m; 0.00212 if left out: the middle one is then the default, 3 mm",
    )  # fmt: skip
    parser.add_argument("--prestretch", type=float, nargs="+", default=[1.06, 1.15])
    parser.add_argument("--output", type=Path, metavar="FILE", help="write the table there, too")
    return parser.parse_args(words)


if __name__ == "__main__":
    sys.exit(main())
