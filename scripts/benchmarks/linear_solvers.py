"""The sparse solvers beside each other, on the stiffness of a dome."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from benchmarks.sections import least_cpu
from benchmarks.shell_release import BenchmarkCase
from bilayer import generate_mesh
from dshell import MorleySettings
from dshell.energies.assembly import Assembly, deform
from dshell.models.morley import MorleyModel
from dshell.release.rigid_motion import choose_far_nodes, held_coordinates
from dshell.solve.linear_solver import (
    MUMPS_ORDERINGS,
    CholmodSolver,
    LinearSolver,
    MumpsSolver,
    SuperLUSolver,
)
from dshell.solve.newton import CONVEX_SHIFT

REPEATS = 3


def stiffness_of_a_dome(triangles: int) -> csc_matrix:
    """Return the convex stiffness of the paper's specimen on a paraboloid."""
    specimen = BenchmarkCase(triangles).specimen()
    mesh = generate_mesh(specimen)
    model = MorleyModel(specimen, mesh, MorleySettings())
    energies = model.energies((1.15, 1.15))
    x, y = mesh.points.T
    dome = np.column_stack([x, y, -8.0 * (x**2 + y**2)])  # a sphere of about 60 mm
    state = np.concatenate([dome.reshape(-1), np.zeros(model.extra_dofs)])
    assembly = Assembly(len(state), energies, held_coordinates(choose_far_nodes(mesh)))
    matrix = assembly.convex_hessian(deform(energies, state))
    matrix.setdiag(matrix.diagonal() + CONVEX_SHIFT * matrix.diagonal().mean())
    return matrix


def costs(triangles: int) -> Iterator[dict[str, Any]]:
    """Yield the CPU time of each solver on one mesh, s."""
    matrix = stiffness_of_a_dome(triangles)
    solvers: list[LinearSolver] = [CholmodSolver(), *map(MumpsSolver, MUMPS_ORDERINGS)]
    for solver in [*solvers, SuperLUSolver()]:
        yield {"dofs": matrix.shape[0], **_cost(solver, matrix)}


def _cost(solver: LinearSolver, matrix: csc_matrix) -> dict[str, Any]:
    right = np.random.default_rng(0).normal(size=matrix.shape[0])
    first = least_cpu(lambda: solver.cholesky(matrix), 1)
    again = least_cpu(lambda: solver.cholesky(matrix), REPEATS)
    factor = solver.cholesky(matrix)
    solution = least_cpu(lambda: factor.solve(right), REPEATS)
    residual = np.linalg.norm(matrix @ factor.solve(right) - right) / np.linalg.norm(right)
    return {
        "solver": solver.name,
        "ordering": getattr(solver, "used_ordering", "its own"),
        "with its analysis (s)": first,
        "factorisation (s)": again,
        "solution (s)": solution,
        "residual": residual,
    }
