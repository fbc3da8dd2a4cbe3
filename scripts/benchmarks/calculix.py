"""The finite-element model beside CalculiX: CPU seconds and errors.

CalculiX runs outside the environment of the benchmarks: scripts/benchmark_calculix runs it first.
In a folder it leaves specimen.toml and, for each mesh size in mm, SIZE.nc and SIZE.seconds (a line
"deck_1.03 24.4" per prestretch).
"""

import argparse
import resource
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import xarray as xr

from bilayer import open_result, result_mesh, write_planar_mesh
from bilayer.errors import ComputationError

DESCRIPTION = "the finite-element model beside CalculiX: CPU time and errors on the same meshes"
EXAMPLES = """\
  scripts/benchmark_calculix 8             # runs CalculiX, too, and then this
  scripts/benchmark calculix FOLDER 8      # on what CalculiX left in a folder"""
SINGLES = (1.03, 1.06, 1.15)
REFERENCE_SIZE = "2.1"
MUST, AIM = 5, 15


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add where CalculiX's runs are."""
    parser.add_argument("folder", type=Path, help="what scripts/benchmark_calculix made")
    parser.add_argument("sizes", nargs="+", metavar="SIZE", help="mesh sizes, mm")


def tables(options: argparse.Namespace) -> Iterator[str]:
    """Yield the table as text."""
    folder = options.folder
    reference = solve(folder, "reference", ["--mesh-size", f"{REFERENCE_SIZE}e-3"])[0]
    rows = [row for size in options.sizes for row in compared(folder, size, reference)]
    yield (
        "CPU seconds of the programs, errors of the radius of the best sphere against the "
        f"finite-element model on a mesh of {REFERENCE_SIZE} mm. Ratio: CalculiX over ours; "
        f"must {MUST}, aim on the sweep {AIM}\n" + pd.DataFrame(rows).to_string(index=False)
    )


def compared(folder: Path, size: str, reference: xr.Dataset) -> list[dict[str, str]]:
    """One row for each single prestretch and one for the sweep, on one mesh size."""
    theirs, seconds = open_result(folder / f"{size}.nc"), read_seconds(folder / f"{size}.seconds")
    mesh = folder / f"{size}.vtu"
    write_planar_mesh(result_mesh(theirs), mesh)
    rows = []
    for stretch in SINGLES:
        ours, spent = solve(folder, size, ["--mesh", str(mesh), "--prestretch", str(stretch)])
        rows.append(
            row(size, f"{stretch:g}", seconds[stretch], spent,
                error(theirs.sel(prestretch=[stretch]), reference), error(ours, reference))
        )  # fmt: skip
    ours, spent = solve(folder, size, ["--mesh", str(mesh)])
    rows.append(
        row(size, "sweep", sum(seconds.values()), spent,
            error(theirs, reference), error(ours, reference))
    )  # fmt: skip
    return rows


def row(
    size: str, case: str, theirs: float, ours: float, their_error: float, our_error: float
) -> dict[str, str]:
    return {
        "mesh mm": size,
        "prestretch": case,
        "CalculiX CPU s": f"{theirs:.1f}",
        "error": f"{100 * their_error:.2f} %",
        "ours CPU s": f"{ours:.1f}",
        "error ": f"{100 * our_error:.2f} %",
        "ratio": f"{theirs / ours:.1f}",
    }


def solve(folder: Path, name: str, options: list[str]) -> tuple[xr.Dataset, float]:
    """Return a result of `bilayer solve` with its defaults, and the CPU seconds of the process."""
    output = folder / f"fenics_{name}.nc"
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    command = ["bilayer", "solve", str(folder / "specimen.toml"), "--solver", "fenics",
               "-o", str(output), "--quiet", *options]  # fmt: skip
    if subprocess.run(command, check=False).returncode not in (0, 1):
        raise ComputationError(f"{' '.join(command)}: failed")
    return open_result(output), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def read_seconds(path: Path) -> dict[float, float]:
    """Return CPU seconds by prestretch."""
    words = [line.split() for line in path.read_text().splitlines()]
    return {float(name.removeprefix("deck_")): float(spent) for name, spent in words}


def error(result: xr.Dataset, reference: xr.Dataset) -> float:
    """Largest relative error of the radius of the best sphere; NaN if one is missing."""
    expected = reference["sphere_radius"].sel(prestretch=result["prestretch"])
    return float(abs(result["sphere_radius"] / expected - 1).max(skipna=False))
