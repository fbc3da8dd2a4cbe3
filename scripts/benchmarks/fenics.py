"""What the finite-element model takes: iterations, CPU seconds by part, kernels, ranks.

The paper's specimen at its eight prestretches on one planar mesh. CPU seconds are of one process
and one thread; those of two ranks are added up. CalculiX beside it: scripts/benchmark_calculix.
"""

import argparse
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI

from bilayer import MeshSize, generate_mesh, open_result, paper_specimen, specimen_to_toml
from bilayer.planar_mesh import PlanarMesh
from bilayer.specimen import Specimen
from fenics_model import SolidSettings, jit
from fenics_model.bilayer_solid import bilayer_solid
from fenics_model.solid import Solid

STARTS = ("shell", "flat")
SINGLES = (1.03, 1.06)
DEGREES = (2, 3, 4)
REFERENCE_DEGREE = 6
COMPILERS = {"-O2": ["-O2"], "-O3 -march=native": ["-O3", "-march=native"]}
REPETITIONS = 5
MUST = {"shell": 80, "flat": 97, 1.03: 8, 1.06: 12}
AIM = {"shell": 50, "flat": 70}


def main(words: Sequence[str]) -> int:
    parser = argparse.ArgumentParser(prog="scripts/benchmark fenics", description=__doc__)
    parser.add_argument("--mesh-size", type=float, default=6.0, metavar="MM", help="default 6")
    size = parser.parse_args(words).mesh_size
    specimen = replace(paper_specimen(), mesh=MeshSize(1e-3 * size))
    mesh = generate_mesh(specimen)
    print(f"{len(mesh.triangles)} triangles of {size:g} mm\n")
    with tempfile.TemporaryDirectory() as folder:
        show("Newton iterations, all counted", iterations(specimen, Path(folder)))
    show("Kernels, the fastest of some repetitions", kernels(specimen, mesh))
    show("Quadrature: error of the radius at 1.06", quadrature(specimen, mesh))
    return 0


def show(title: str, rows: Sequence[dict[str, str]]) -> None:
    print(f"{title}\n{pd.DataFrame(rows).to_string(index=False)}\n", flush=True)


def iterations(specimen: Specimen, folder: Path) -> list[dict[str, str]]:
    """One row for each start of the sweep, for single prestretches, and for two ranks."""
    rows = []
    sweeps = [solve(specimen, folder, start) for start in STARTS]
    for start, (result, spent) in zip(STARTS, sweeps, strict=True):
        row = effort(f"sweep, {start}", result, spent)
        rows.append(row | {"must": str(MUST[start]), "aim": str(AIM[start])})
    for stretch in SINGLES:
        result, spent = solve(specimen.with_milestones([stretch]), folder, "shell")
        rows.append(effort(f"{stretch:g}, shell", result, spent) | {"must": str(MUST[stretch])})
    result, spent = solve(specimen, folder, "shell", ranks=2)
    rows.append(effort("sweep, shell, 2 ranks", result, spent))
    found = [result for result, _ in sweeps] + [result]
    apart = [largest_distance(found[0], other) for other in found[1:]]
    print(f"shapes: flat start {apart[0]:.0e} m, two ranks {apart[1]:.0e} m from the first\n")
    return [{name: row.get(name, "") for name in rows[0]} for row in rows]


def solve(specimen: Specimen, folder: Path, start: str, ranks: int = 1) -> tuple[xr.Dataset, float]:
    """Return a result of `bilayer solve` and the CPU seconds of all its processes."""
    case, output = folder / "specimen.toml", folder / "result.nc"
    case.write_text(specimen_to_toml(specimen))
    launcher = ["mpirun", "-n", str(ranks)] if ranks > 1 else []
    command = [*launcher, "bilayer", "solve", str(case), "--solver", "fenics", "--start", start,
               "-o", str(output), "--quiet"]  # fmt: skip
    before = children_seconds()
    subprocess.run(command, check=True)
    return open_result(output), children_seconds() - before


def children_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def effort(case: str, result: xr.Dataset, spent: float) -> dict[str, str]:
    counts = result["iterations"].values
    assembly, factorisation, total = (
        float(result[name].sum()) for name in ("assembly_time", "factorisation_time", "cpu_time")
    )
    return {
        "case": case,
        "by milestone": " ".join(map(str, counts)),
        "sum": str(counts.sum()),
        "must": "",
        "aim": "",
        "factorisations": str(int(result["factorisations"].sum())),
        "unstable": str(int(result["unstable_modes"].max())),
        "assembly s": f"{assembly:.1f}",
        "factorisation s": f"{factorisation:.1f}",
        "rest s": f"{total - assembly - factorisation:.1f}",
        "process s": f"{spent:.1f}",
    }


def largest_distance(one: xr.Dataset, other: xr.Dataset) -> float:
    return float(np.abs(one["position"].values - other["position"].values).max())


def kernels(specimen: Specimen, mesh: PlanarMesh) -> list[dict[str, str]]:
    """Microseconds per dof of residual and tangent, by compiler options and quadrature."""
    rows = []
    for compiler, flags in COMPILERS.items():
        for degree in DEGREES:
            with_flags = jit.JIT_OPTIONS | {"cffi_extra_compile_args": [*flags, "-g0"]}
            solid = built(specimen, mesh, degree, with_flags)
            dofs = solid.space.dofmap.index_map.size_global * solid.space.dofmap.index_map_bs
            matrix = fem_petsc.create_matrix(solid.tangent.form)
            tangent = fastest(lambda: fem_petsc.assemble_matrix(matrix, solid.tangent.form))  # noqa: B023
            residual = fastest(lambda: fem.assemble_vector(solid.residual))  # noqa: B023
            matrix.destroy()
            rows.append(
                {
                    "compiler": compiler,
                    "degree": str(degree),
                    "dofs": str(dofs),
                    "residual us/dof": f"{1e6 * residual / dofs:.2f}",
                    "tangent us/dof": f"{1e6 * tangent / dofs:.2f}",
                }
            )
    return rows


def built(specimen: Specimen, mesh: PlanarMesh, degree: int, options: dict) -> Solid:
    """Return the solid, its forms compiled with some options."""
    kept = dict(jit.JIT_OPTIONS)
    jit.JIT_OPTIONS.update(options)
    try:
        settings = SolidSettings(quadrature_degree=degree)
        return bilayer_solid(specimen, mesh, settings, MPI.COMM_SELF).solid
    finally:
        jit.JIT_OPTIONS.update(kept)


def fastest(call: Callable[[], object]) -> float:
    """CPU seconds of the fastest of some calls, because the machine is shared."""
    spent = []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        call()
        spent.append(time.process_time() - begin)
    return min(spent)


def quadrature(specimen: Specimen, mesh: PlanarMesh) -> list[dict[str, str]]:
    """Radius of the best sphere by the degree that the quadrature integrates."""
    from bilayer.solvers import solve as solve_in_process

    single = specimen.with_milestones([1.06])
    radius = {
        degree: float(
            solve_in_process(single, "fenics", SolidSettings(quadrature_degree=degree), mesh=mesh)[
                "sphere_radius"
            ][0]
        )
        for degree in (*DEGREES, REFERENCE_DEGREE)
    }
    exact = radius[REFERENCE_DEGREE]
    return [
        {
            "degree": str(degree),
            "radius mm": f"{1e3 * found:.4f}",
            f"from degree {REFERENCE_DEGREE}": f"{found / exact - 1:+.1e}",
        }
        for degree, found in radius.items()
    ]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
