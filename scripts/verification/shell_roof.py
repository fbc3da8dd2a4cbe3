"""The hinged roof of `hinged_roof` as a Morley shell. SI units.

The shell's own reference is flat. Bent to the cylinder it has no stress if its natural curvature is
that of the cylinder: two like layers, the lower one stretched.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bilayer import LinearElastic
from bilayer.mesh.planar import PlanarMesh
from dshell.energies.assembly import Assembly, coordinates_of
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.through_thickness import ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from dshell.solve.linear_solver import best_linear_solver
from dshell.solve.newton import Body, Configuration, EquilibriumSolver
from verification.arc_length import PathPoint
from verification.hinged_roof import (
    HALF_ANGLE,
    LENGTH,
    POISSON,
    RADIUS,
    YOUNG,
    Curve,
    curves_of,
    on_cylinder,
    path_of,
)
from verification.meshes import rectangle
from verification.shell_problem import plate

Array = NDArray[np.float64]


def roof_mesh(cells: int) -> PlanarMesh:
    """Return the mesh of the flat roof about its centre, x across, y along the straight edges."""
    half = RADIUS * HALF_ANGLE
    return rectangle(
        np.linspace(-half, half, cells + 1), np.linspace(-LENGTH / 2, LENGTH / 2, cells + 1)
    )


@dataclass(frozen=True)
class ShellRoof:
    """The roof as a Morley shell; see `verification.arc_length.Loaded`.

    Parameters
    ----------
    thickness : float
        m.
    cells : int
        Along each side, even.
    """

    thickness: float
    cells: int

    @cached_property
    def mesh(self) -> PlanarMesh:
        """The flat mesh."""
        return roof_mesh(self.cells)

    @cached_property
    def start(self) -> Array:
        """The state on the cylinder."""
        rest = np.zeros(self._faces.edge_count)
        return np.concatenate([on_cylinder(self.mesh.points).reshape(-1), rest])

    @cached_property
    def _faces(self) -> MorleyFaces:
        law = plane_stress_law(LinearElastic(YOUNG, POISSON))
        half, stretch = self.thickness / 2, 2 * self.thickness / 3 / RADIUS
        lower = np.diag([1 + stretch / 2, 1.0])
        upper = np.diag([1 - stretch / 2, 1.0])
        layers = [ShellLayer("lower", law, -half, 0.0, lower),
                  ShellLayer("upper", law, 0.0, half, upper)]  # fmt: skip
        return plate(self.mesh, layers)[0]

    @cached_property
    def _centre(self) -> int:
        """The dof that the force acts on."""
        return 3 * int(np.argmin(np.linalg.norm(self.mesh.points, axis=1))) + 2

    @cached_property
    def _solver(self) -> EquilibriumSolver:
        edges = np.abs(self.mesh.points[:, 0]) > RADIUS * HALF_ANGLE * (1 - 1e-9)
        held = coordinates_of(np.flatnonzero(edges)).reshape(-1)
        assembly = Assembly(len(self.start), [self._faces], held)
        return EquilibriumSolver(assembly, best_linear_solver())

    def _configure(self, state: Array, force: float = 0.0) -> Configuration:
        load = np.zeros(len(state))
        load[self._centre] = -force
        return self._solver.configure(Body([self._faces], load), state)

    def residual(self, state: Array, force: float) -> Array:
        """See `Loaded`."""
        return self._configure(state, force).residual

    def solve(self, state: Array, *right_sides: Array) -> list[Array]:
        """See `Loaded`."""
        factor = self._solver.factor(self._configure(state).hessian())
        return [factor.solve(side) for side in right_sides]

    def unit_force(self) -> Array:
        """See `Loaded`."""
        return -(self._solver.assembly.free == self._centre).astype(float)

    def moved(self, state: Array, step: Array) -> Array:
        """See `Loaded`."""
        after = state.copy()
        after[self._solver.assembly.free] += step
        return after

    def deflection(self, state: Array) -> float:
        """See `Loaded`."""
        return -float(state[self._centre])

    def deflection_of(self, step: Array) -> float:
        """See `Loaded`."""
        return -float(step[self._solver.assembly.free == self._centre][0])


def shell_curve(thickness: float, cells: int, step: float = 0.05) -> list[PathPoint[Array]]:
    """Return the curve of a roof, through both limit points."""
    roof = ShellRoof(thickness, cells)
    return path_of(roof, _at_rest(roof), thickness, step)


def shell_curves(cells: int) -> dict[float, Curve]:
    """Return the curves of both roofs, by thickness."""
    return curves_of(lambda thickness: shell_curve(thickness, cells))


def _at_rest(roof: ShellRoof) -> Array:
    """Return the equilibrium without force: the folds between flat faces relax a little."""
    state = roof.start
    for _ in range(10):
        residual = roof.residual(state, 0.0)
        if np.linalg.norm(residual) < 1e-6:
            break
        (step,) = roof.solve(state, residual)
        state = roof.moved(state, -step)
    return state
