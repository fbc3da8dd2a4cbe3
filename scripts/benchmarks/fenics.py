"""The cost of the finite-element model: iterations, CPU seconds by part, kernels, ranks.

The paper's specimen at its eight prestretches on one planar mesh. CPU seconds are of one process
and one thread; "process" adds up the ranks, imports and the shell. CalculiX beside it:
scripts/benchmark calculix.
"""

import argparse
import resource
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import xarray as xr
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI

import bilayer
from benchmarks.page import table_text
from benchmarks.sections import least_cpu
from bilayer import MeshSize, generate_mesh, open_result, paper_specimen, specimen_to_toml
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from fenics_model import SolidSettings
from fenics_model.api import jit
from fenics_model.release.specimen_solid import make_solid
from fenics_model.solid.solid import Solid

DESCRIPTION = "the finite-element model: iterations, CPU time by part, kernels, ranks"
EXAMPLES = """  scripts/benchmark fenics
  scripts/benchmark fenics --mesh-size 4"""

STARTS = ("shell", "flat")
SINGLES = (1.03, 1.06)
RANKS = (2, 4)
DEGREES = (2, 3, 4)
REFERENCE_DEGREE = 6
COMPILERS = {
    "-O2": ["-O2"],
    "-O2, sums in any order": ["-O2", *jit.SUMS_IN_ANY_ORDER],
    "-O3 -march=native": ["-O3", "-march=native"],
    "-O3 -march=native, sums in any order": ["-O3", "-march=native", *jit.SUMS_IN_ANY_ORDER],
}
REPETITIONS = 5
MUST = {"shell": 80, "flat": 97, 1.03: 8, 1.06: 12}
AIM = {"shell": 50, "flat": 70}


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add what this benchmark asks for."""
    parser.add_argument("--mesh-size", type=float, default=6.0, metavar="MM", help="default 6")


def tables(options: argparse.Namespace) -> Iterator[str]:
    """Yield the tables as texts."""
    specimen = replace(paper_specimen(), mesh=MeshSize(1e-3 * options.mesh_size))
    mesh = generate_mesh(specimen)
    where = f"{len(mesh.triangles)} triangles of {options.mesh_size:g} mm"
    with tempfile.TemporaryDirectory() as folder:
        yield _titled(
            f"Newton iterations, all counted; {where}", iterations(specimen, Path(folder))
        )
    yield _titled("Kernels, CPU time of the fastest of some repetitions", kernels(specimen, mesh))
    yield _titled("Quadrature: the radius of the best sphere at 1.06", quadrature(specimen, mesh))


def _titled(title: str, rows: Sequence[dict[str, str]]) -> str:
    return f"{title}\n{table_text(rows)}"


def iterations(specimen: Specimen, folder: Path) -> list[dict[str, str]]:
    """One row for each start of the sweep, for single prestretches, and for more ranks."""
    rows = []
    sweeps = [solve(specimen, folder, start) for start in STARTS]
    for start, (result, spent) in zip(STARTS, sweeps, strict=True):
        row = effort(f"sweep, {start}", result, spent)
        rows.append(row | {"must": str(MUST[start]), "aim": str(AIM[start])})
    for stretch in SINGLES:
        single = specimen.with_milestones([stretch])
        result, spent = solve(single, folder, "shell")
        rows.append(effort(f"{stretch:g}, shell", result, spent) | {"must": str(MUST[stretch])})
    for ranks in RANKS:  # of the last single one
        split, spent = solve(single, folder, "shell", ranks)
        row = effort(f"{stretch:g}, shell, {ranks} ranks", split, spent)
        rows.append(row | {"from one start or rank": f"{largest_distance(result, split):.0e} m"})
    (shell, _), (flat, _) = sweeps
    rows[1]["from one start or rank"] = f"{largest_distance(shell, flat):.0e} m"
    return rows


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
        "factori- sations": str(int(result["factorisations"].sum())),
        "unstable": str(int(result["unstable_modes"].max())),
        "assembly s": f"{assembly:.1f}",
        "factori- sation s": f"{factorisation:.1f}",
        "rest s": f"{total - assembly - factorisation:.1f}",
        "process s": f"{spent:.1f}",
        "from one start or rank": "",
    }


def largest_distance(one: xr.Dataset, other: xr.Dataset) -> float:
    return float(np.abs(one["position"].values - other["position"].values).max())


def kernels(specimen: Specimen, mesh: PlanarMesh) -> list[dict[str, str]]:
    """Microseconds per dof of residual and tangent, by compiler options and quadrature."""
    return [
        {"compiler": compiler, "degree": str(degree)}
        | kernel_times(built(specimen, mesh, degree, flags))
        for compiler, flags in COMPILERS.items()
        for degree in DEGREES
    ]


def kernel_times(solid: Solid) -> dict[str, str]:
    dofs = solid.space.dofmap.index_map.size_global * solid.space.dofmap.index_map_bs
    matrix = fem_petsc.create_matrix(solid.tangent.form)
    tangent = least_cpu(lambda: fem_petsc.assemble_matrix(matrix, solid.tangent.form), REPETITIONS)
    residual = least_cpu(lambda: fem.assemble_vector(solid.residual), REPETITIONS)
    matrix.destroy()
    return {
        "dofs": str(dofs),
        "residual us/dof": f"{1e6 * residual / dofs:.2f}",
        "tangent us/dof": f"{1e6 * tangent / dofs:.2f}",
    }


def built(specimen: Specimen, mesh: PlanarMesh, degree: int, flags: list[str]) -> Solid:
    """Return the solid, its forms compiled with some flags."""
    kept = dict(jit.JIT_OPTIONS)
    jit.JIT_OPTIONS["cffi_extra_compile_args"] = [*flags, "-g0"]
    try:
        settings = SolidSettings(quadrature_degree=degree)
        return make_solid(specimen, mesh, settings, MPI.COMM_SELF).solid
    finally:
        jit.JIT_OPTIONS.update(kept)


def quadrature(specimen: Specimen, mesh: PlanarMesh) -> list[dict[str, str]]:
    """Radius of the best sphere by the degree that the quadrature integrates."""
    single = specimen.with_milestones([1.06])
    radius = {
        degree: float(
            bilayer.solve(single, "fenics", SolidSettings(quadrature_degree=degree), mesh=mesh)[
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
