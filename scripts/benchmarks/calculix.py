"""CPU seconds and errors of the finite-element model beside those of CalculiX, as a table.

Started by scripts/benchmark_calculix, which runs CalculiX first: it leaves SIZE.nc and
SIZE.seconds (a line "deck_1.03 24.4" per prestretch) for each mesh size in mm.
"""

import resource
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pandas as pd
import xarray as xr

from bilayer import open_result, result_mesh, write_planar_mesh

SINGLES = (1.03, 1.06, 1.15)
REFERENCE_SIZE = "3"
MUST, AIM = 5.0, 15.0


def main(words: Sequence[str]) -> int:
    folder, sizes = Path(words[0]), words[1:]
    reference = solve(folder, "reference", ["--mesh-size", f"{REFERENCE_SIZE}e-3"])[0]
    rows = [row for size in sizes for row in compared(folder, size, reference)]
    print(f"errors against a mesh of {REFERENCE_SIZE} mm; ratio: of CPU times, CalculiX over ours")
    print(pd.DataFrame(rows).to_string(index=False))
    print(f"must {MUST:g}, aim on the sweep {AIM:g}")
    return 0


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
    subprocess.run(command, check=True)
    return open_result(output), resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def read_seconds(path: Path) -> dict[float, float]:
    """Return CPU seconds by prestretch."""
    words = [line.split() for line in path.read_text().splitlines()]
    return {float(name.removeprefix("deck_")): float(spent) for name, spent in words}


def error(result: xr.Dataset, reference: xr.Dataset) -> float:
    """Largest relative error of the radius of the best sphere; NaN where one is missing."""
    expected = reference["sphere_radius"].sel(prestretch=result["prestretch"])
    return float(abs(result["sphere_radius"] / expected - 1).max(skipna=False))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
