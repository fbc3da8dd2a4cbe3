"""A Morley shell of any layers on any mesh, under dead loads, some coordinates held.

A clamp is a row of faces beside the clamped edge, stiff and held: the shell's own unknowns then
keep the slope there, and nothing in it knows of clamps. SI units.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import eigsh

from bilayer import LinearElastic, PlanarMesh
from bilayer.solvers.path import follow_path
from dshell.energies.assembly import Energy
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.skin_contact import SkinContact
from dshell.energies.through_thickness import PROFILES, Laminate, ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from dshell.release.branches import NextEquilibriumRule
from dshell.release.static import ShellState, StaticPath, StepLimits, equilibrium_solver
from dshell.solve.linear_solver import best_linear_solver
from dshell.solve.newton import Body, EquilibriumSolver

Array = NDArray[np.float64]
CLAMP_STIFFNESS = 1e3
"""Young's modulus of a clamp over that of what it clamps."""


Share = tuple[float]
"""The load of a problem's path: which part of its full load acts."""
FULL: Share = (1.0,)


@dataclass
class Problem:
    """A shell under loads, some of its degrees of freedom held.

    See `dshell.release.static.ShellProblem`: the load of its path is the share of the dead load.
    """

    faces: MorleyFaces
    flat_state: Array
    held: NDArray[np.int64]
    load: Array
    more: Sequence[Energy] = ()
    """Energies beside that of the faces, such as a moment's."""
    contact: SkinContact | None = None
    """What the shell is kept off."""

    unloaded: Share = (0.0,)
    least_force = 0.0

    @property
    def energies(self) -> list[Energy]:
        """All of them, the faces' first."""
        return [self.faces, *self.more]

    def way(self, start: Share, end: Share) -> float:
        """The change of the share."""
        return abs(end[0] - start[0])

    def name_of(self, share: Share) -> str:
        """The share as a text."""
        return f"{share[0]:.6g}"

    def flat(self, share: Share) -> Array:
        """The flat state."""
        return self.flat_state

    def body(self, share: Share) -> Body:
        """The shell under a share of its load."""
        return Body(self.energies, share[0] * self.load, self.contact)

    def path(
        self, tolerance: float = 1e-9, longest_step: float = 1.0, iterations: int = 60
    ) -> StaticPath[Share]:
        """The load path: each equilibrium in one step from the one before, stable or not."""
        solver = self._solver()
        limits = StepLimits(tolerance, iterations, longest_step)
        return StaticPath(self, limits, solver, NextEquilibriumRule(solver))

    def solved(
        self,
        tolerance: float = 1e-9,
        longest_step: float = 1.0,
        start: Array | None = None,
        iterations: int = 60,
    ) -> Array:
        """State in equilibrium under the load, from flat or from another state."""
        path = self.path(tolerance, longest_step, iterations)
        if start is not None:
            path.move_to(ShellState(self.unloaded, start))
        (state,) = states_on(path, [FULL])
        return state

    def unstable_modes(self, state: Array) -> int:
        """Number of negative eigenvalues of the Hessian."""
        return self._solver().unstable_modes(self.body(FULL), state)

    def least_stiffness(self, state: Array) -> float:
        """Eigenvalue of the Hessian nearest to 0, N/m."""
        hessian = self._solver().configure(self.body(FULL), state).hessian()
        begin = np.random.default_rng(0).normal(size=hessian.shape[0])
        return float(eigsh(hessian, k=1, sigma=0.0, v0=begin, return_eigenvectors=False)[0])

    def _solver(self) -> EquilibriumSolver:
        return equilibrium_solver(self, best_linear_solver())


def states_on(path: StaticPath[Share], shares: Sequence[Share]) -> Iterator[Array]:
    """The states in equilibrium at shares of the load, one after the other."""
    for step in follow_path(path, shares):
        if step.failure is not None:
            raise step.failure
        yield step.point.state


def plate(mesh: PlanarMesh, layers, profile="linear") -> tuple[MorleyFaces, Array]:
    """Faces of some layers on a mesh, and their flat state."""
    laminate = Laminate(layers, PROFILES[profile])
    faces = MorleyFaces(mesh.points, mesh.triangles, laminate)
    nodes = np.column_stack([mesh.points, np.zeros(len(mesh.points))]).reshape(-1)
    return faces, np.concatenate([nodes, np.zeros(faces.edge_count)])


def single_layer(young_modulus, poisson_ratio, thickness, prestretch=(1.0, 1.0)) -> ShellLayer:
    """A linear layer about its own mid-plane."""
    law = plane_stress_law(LinearElastic(young_modulus, poisson_ratio))
    return ShellLayer("plate", law, -thickness / 2, thickness / 2, np.diag(prestretch))


def clamp_layer(mesh: PlanarMesh, clamped_nodes, young_modulus, thickness) -> ShellLayer:
    """A layer, without Poisson's effect, that stiffens the faces between clamped nodes."""
    law = plane_stress_law(LinearElastic(CLAMP_STIFFNESS * young_modulus, 0.0))
    between = np.flatnonzero(np.isin(mesh.triangles, clamped_nodes).all(axis=1))
    return ShellLayer("clamp", law, -thickness / 2, thickness / 2, np.eye(2), between)


def nodes_of(state: Array, mesh: PlanarMesh) -> Array:
    """Positions of the nodes, (n, 3)."""
    return state[: 3 * len(mesh.points)].reshape(-1, 3)


def pressure(mesh: PlanarMesh, size: int, load_per_area: float) -> Array:
    """Dead load along z on the whole mesh, in the shape of a state of that size."""
    load = np.zeros(size)
    np.add.at(load, 3 * mesh.triangles + 2, load_per_area * mesh.areas[:, None] / 3)
    return load


def line_load(
    mesh: PlanarMesh, size: int, line: NDArray[np.int64], load_per_length: float
) -> Array:
    """Dead load along z on a line of neighbouring nodes, in the shape of a state of that size."""
    load = np.zeros(size)
    pieces = np.linalg.norm(np.diff(mesh.points[line], axis=0), axis=1)
    for ends in (line[:-1], line[1:]):
        np.add.at(load, 3 * ends + 2, load_per_length * pieces / 2)
    return load
