"""The finite-element model against CalculiX, an independent finite-element program.

What CalculiX computed is kept in results/calculix/, made anew by scripts/verify_calculix: it runs
outside the environment in which the rungs run. The finite-element model is solved here.
"""

from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from bilayer import open_result, result_mesh, result_specimen, solve
from bilayer.results.comparison import compare
from verification.rung import Check, Rung

RESULTS = Path(__file__).parents[2] / "results" / "calculix"
MEASURES = ("height", "span x", "span y")


def compared_on(mesh: str) -> xr.Dataset:
    """Return the comparison of the finite-element model, first, with CalculiX's kept result."""
    reference = open_result(RESULTS / f"{mesh}.nc")
    specimen = result_specimen(reference)
    return compare(solve(specimen, "fenics", mesh=result_mesh(reference)), reference)


def against_calculix() -> Iterator[Check]:
    distances = {}
    for mesh, tolerance in (("8mm", None), ("5mm", 0.01)):
        compared = compared_on(mesh)
        for stretch in compared["prestretch"].values:
            case = compared.sel(prestretch=stretch)
            sizes = [case["height"], case["span"].sel(xyz="x"), case["span"].sel(xyz="y")]
            for name, pair in zip(MEASURES, sizes, strict=True):
                ours, theirs = 1e3 * pair.values
                what = f"{mesh} mesh, prestretch {stretch:g}: {name} (mm)"
                yield Check(what, float(ours), float(theirs), tolerance)
            distances[mesh, stretch] = float(case["rms_distance_over_radius"])
            what = f"{mesh} mesh, prestretch {stretch:g}: rms / R"
            yield Check(what, distances[mesh, stretch], 0.0, tolerance, 1.0)
    for stretch in compared["prestretch"].values:
        shrunk = distances["5mm", stretch] / distances["8mm", stretch]
        what = f"prestretch {stretch:g}: rms at 5 mm over rms at 8 mm"
        yield Check(what, shrunk, 0.0, 1.0, 1.0)


CALCULIX_RUNGS = (
    Rung(
        16, "fenics", "Against CalculiX",
        "The paper's specimen by CalculiX 2.20 with quadratic hexahedra (results/calculix, made by "
        "`scripts/verify_calculix`), on the same planar mesh with the same constants.",
        against_calculix,
    ),
)  # fmt: skip
