"""One Newton iteration of the model `hinge` beside dismech-python's, on the same disc.

Both have springs on the edges and hinges across them, stretch and bend, and are assembled and
solved with one thread. The peer stays in its own checkout and interpreter.
"""

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from verification.meshes import disc

from benchmarks.sections import least_cpu
from bilayer import PlanarMesh, paper_specimen
from bilayer.errors import ComputationError, InputError
from dshell.energies.assembly import Assembly, deform, gradient_of
from dshell.models.hinge import HingeModel
from dshell.release.rigid_motion import choose_far_nodes, held_coordinates
from dshell.solve.linear_solver import best_linear_solver

RINGS = (16, 32)
"""Of nodes in the discs: 2256 and 9120 hinges."""
REPEATS = 7
STRETCH = (1.06, 1.06)
TIME_LIMIT = 600  # s, of the peer on one mesh


def check_peer(checkout: Path, interpreter: Path) -> None:
    """Raise InputError if the checkout or its interpreter is not there."""
    if not (checkout / "src" / "dismech").is_dir():
        raise InputError(f"--peer {checkout}: expected a checkout of dismech-python (src/dismech)")
    if not interpreter.exists():
        raise InputError(f"--peer-python {interpreter}: expected the peer's Python interpreter")


def costs(checkout: Path, interpreter: Path) -> Iterator[dict[str, Any]]:
    """Yield CPU seconds of both programs on each disc."""
    for rings in RINGS:
        mesh = disc(rings, paper_specimen().characteristic_length / rings)
        ours = _our_cost(mesh)
        size = {"hinges": ours.pop("hinges"), "dofs": ours.pop("dofs")}
        theirs = _peer_cost(mesh, checkout, interpreter)
        for program, cost in (("dshell hinge", ours), ("dismech-python", theirs)):
            total = cost["assembly"] + cost["solution"]
            yield {**size, "program": program, **cost, "iteration": total}


def _bent(mesh: PlanarMesh) -> np.ndarray:
    x, y = mesh.points.T
    return np.column_stack([0.98 * x, 0.98 * y, -3.0 * (x**2 + y**2)])


def _our_cost(mesh: PlanarMesh) -> dict[str, Any]:
    specimen = paper_specimen().with_layer("kirigami", pattern=None)
    begin = time.process_time()
    energies = HingeModel(specimen, mesh).energies(STRETCH)
    assembly = Assembly(
        mesh.points.shape[0] * 3, energies, held_coordinates(choose_far_nodes(mesh))
    )
    set_up = time.process_time() - begin
    state = _bent(mesh).reshape(-1)
    solver = best_linear_solver()

    def force_and_stiffness() -> None:
        deformed = deform(energies, state)
        gradient_of(deformed)
        assembly.hessian(deformed)

    bent = deform(energies, state)
    matrix, right = assembly.convex_hessian(bent), gradient_of(bent)[assembly.free]
    solver.cholesky(matrix)  # its analysis is a part of no iteration but the first
    return {
        "hinges": len(energies[1].nodes),
        "dofs": len(state),
        "set_up": set_up,
        "assembly": least_cpu(force_and_stiffness, REPEATS),
        "solution": least_cpu(lambda: solver.cholesky(matrix).solve(right), REPEATS),
    }


def _peer_cost(mesh: PlanarMesh, checkout: Path, interpreter: Path) -> dict[str, float]:
    script = Path(__file__).with_name("peer_iteration.py")
    flat = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "mesh.npz")
        np.savez(file, flat=flat, bent=_bent(mesh), triangles=mesh.triangles)
        command = [interpreter, script, checkout, file, str(REPEATS)]
        one_thread = {"OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        done = subprocess.run(
            [*map(str, command)],
            capture_output=True,
            text=True,
            timeout=TIME_LIMIT,
            env=one_thread,
            check=False,
        )
    if done.returncode != 0:
        last = done.stderr.strip().splitlines()[-1:] or ["no message"]
        raise ComputationError(f"dismech-python stopped: {last[0]}")
    return json.loads(done.stdout.splitlines()[-1])
