"""One release of a specimen by the default shell: what it costs.

Measured in a process of its own, whose peak memory is then the release's.
"""

import multiprocessing
import resource
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from typing import Any

from benchmarks.sections import cpu_by_section
from bilayer import CutPattern, MeshSize, Specimen, generate_mesh, paper_specimen, solve
from bilayer.mesh.generation import size_for
from bilayer.solvers import recording
from dshell import MorleySettings
from dshell.energies import morley_faces
from dshell.energies.assembly import Assembly
from dshell.solve import linear_solver, newton

CPU_PARTS = {
    "set-up": [(Assembly, "__init__"), (morley_faces.MorleyFaces, "__init__")],
    "assembly": [
        (Assembly, "hessian"),
        (Assembly, "convex_hessian"),
        (newton, "deform"),
        (newton, "energy_sums"),
        (newton, "gradient_of"),
    ],
    "factorisation": [
        (kind, name)
        for kind in (linear_solver.CholmodSolver, linear_solver.SuperLUSolver)
        for name in ("cholesky", "factor")
    ],
    "solution": [(linear_solver._PetscSystem, "solve")],
    "measures": [(recording, "measure"), (recording, "build_result")],
}


FEW_TRIANGLES = 100


@dataclass(frozen=True)
class BenchmarkCase:
    """A benchmark case: the paper's specimen with some cutouts, mesh, prestretch and start.

    A fine mesh starts from flat if `coarse_triangles` is 0, see `dshell.ReleaseSettings`.
    """

    triangles: int
    prestretch: float = 1.15
    strips: int = 5
    coarse_triangles: int = 0

    def specimen(self) -> Specimen:
        """Return the specimen, its mesh about as fine as asked for."""
        whole = paper_specimen().with_milestones([self.prestretch])
        size = size_for(self.triangles, whole.characteristic_length)
        cut = whole.layer("kirigami").pattern
        assert isinstance(cut, CutPattern)
        cut_anew = whole.with_layer("kirigami", pattern=replace(cut, strips=self.strips))
        return replace(cut_anew, mesh=MeshSize(size))


def measure_cost(release: BenchmarkCase) -> dict[str, Any]:
    """Return counts, CPU seconds by section, and the process's peak memory in GB."""
    start_up = _start_up()
    specimen = release.specimen()
    begin = time.process_time()
    mesh = generate_mesh(specimen)
    meshing = time.process_time() - begin
    begin = time.process_time()
    with cpu_by_section(CPU_PARTS) as seconds:
        settings = MorleySettings(coarse_triangles=release.coarse_triangles)
        result = solve(specimen, "dshell", settings, mesh=mesh)
    total = time.process_time() - begin
    edges = len(mesh.points) + len(mesh.triangles) - 1  # Euler: the disc has no hole
    return {
        **asdict(release),
        "triangles": len(mesh.triangles),
        "dofs": 3 * len(mesh.points) + edges,
        "converged": bool(result["converged"][0]),
        "iterations": int(result["iterations"][0]),
        "load steps": int(result["load_steps"][0]),
        "unstable modes": int(result["unstable_modes"][0]),
        "sphere radius (mm)": 1e3 * float(result["sphere_radius"][0]),
        "start-up": start_up,
        "meshing": meshing,
        **seconds,
        "rest": total - sum(seconds.values()),
        "total": total,
        "GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9,
    }


def _start_up() -> float:
    """Return the CPU seconds of a small release, the first, which loads libraries such as PETSc."""
    begin = time.process_time()
    solve(BenchmarkCase(FEW_TRIANGLES, prestretch=1.01).specimen(), "dshell")
    return time.process_time() - begin


def in_a_process_of_its_own(function: Callable[..., Any], *args: Any) -> Any:
    """Return the value of a function, called in a new process."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(function, args)
