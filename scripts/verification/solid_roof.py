"""The hinged roof of `hinged_roof` as a solid of the finite-element model: a quarter. SI units."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from numpy.typing import NDArray

from bilayer import MooneyRivlin, PlanarMesh
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.mesh.volume_mesh import Slab, VolumeMesh, extrude
from fenics_model.solid.solid import Solid, SolidLayer
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import energy_constants
from fenics_model.solve.newton import Newton
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
from verification.solid_problem import held_where, newton_of

Array = NDArray[np.float64]
QUARTERS = 4
STIFF = 100.0
"""Moduli of the rim beyond the hinges, over those of the roof."""


@dataclass(frozen=True)
class SolidRoof:
    """A quarter of the roof; see `verification.arc_length.Loaded`. Forces are those on all four.

    Parameters
    ----------
    newton : Newton
        Of the quarter; its matrices and factors are used, not its iteration.
    centre : array of int
        The dofs along z of the fibre at the centre.
    """

    newton: Newton
    centre: NDArray[np.int32]

    @cached_property
    def _unit(self) -> Array:
        force = np.zeros(len(self.newton.solid.undeformed.values))
        force[self.centre] = -1 / QUARTERS / len(self.centre)
        return force

    def residual(self, state: State, force: float) -> Array:
        """See `Loaded`."""
        return self.newton.residual(state) - force * self._unit

    def solve(self, state: State, *right_sides: Array) -> list[Array]:
        """See `Loaded`."""
        with self.newton.factorise(state) as factors:
            return [factors.solve(side) for side in right_sides]

    def unit_force(self) -> Array:
        """See `Loaded`."""
        return self._unit

    def moved(self, state: State, step: Array) -> State:
        """See `Loaded`."""
        return state + step

    def deflection(self, state: State) -> float:
        """See `Loaded`."""
        return self.deflection_of(state.values)

    def deflection_of(self, step: Array) -> float:
        """See `Loaded`."""
        return -float(step[self.centre].mean())


def solid_curve(thickness: float, cells: int, step: float = 0.05) -> list[PathPoint[State]]:
    """Return the curve of a roof, through both limit points.

    Parameters
    ----------
    thickness : float
        m.
    cells : int
        Along each side of the quarter; two through its thickness, the hinges between them.
    step : float
        See `follow_arc`.
    """
    flat = _flat_quarter(thickness, cells)
    volume = extrude(flat, [Slab(thickness, 2, flat.triangles)], below=0.5)
    centre = volume.vertex_at[:, np.argmin(np.linalg.norm(flat.points, axis=1))]
    curved = replace(volume, points=on_cylinder(volume.points))
    solid = _solid(curved)
    with newton_of(solid, _supports(solid)) as newton:
        dofs = solid.mesh.dofs_at(solid.component(2), centre)
        return path_of(SolidRoof(newton, dofs), solid.undeformed, thickness, step)


def solid_curves(cells: int) -> dict[float, Curve]:
    """Return the curves of both roofs, by thickness."""
    return curves_of(lambda thickness: solid_curve(thickness, cells, step=0.1))


def _flat_quarter(thickness: float, cells: int) -> PlanarMesh:
    """Return the mesh of a quarter with a rim beyond the hinge, half as wide as it is thick."""
    across = np.linspace(0, RADIUS * HALF_ANGLE, cells + 1)
    along = np.linspace(0, LENGTH / 2, cells + 1)
    return rectangle(np.append(across, across[-1] + thickness / 2), along)


def _solid(volume: VolumeMesh) -> Solid:
    """Return the solid, stiff in the rim.

    A hinge is a line in the middle of the edge. The edge of a shell stays straight through its
    thickness as it turns about that line; a solid, held along a line, would yield around it.
    """
    mesh = LayeredMesh(volume, MPI.COMM_WORLD)
    space = fem.functionspace(mesh.mesh, ("DG", 0))
    beyond = RADIUS * np.sin(HALF_ANGLE) * (1 + 1e-6)

    def stiff_beyond(value: float, factor: float) -> fem.Function:
        values = fem.Function(space)
        values.interpolate(lambda x: value * np.where(x[0] > beyond, factor, 1.0))
        return values

    kind, values = energy_constants(MooneyRivlin.from_moduli(YOUNG, POISSON))
    energy = kind(**{
        name: stiff_beyond(value, 1 / STIFF if name == "d1" else STIFF)
        for name, value in values.items()
    })  # fmt: skip
    natural = fem.Constant(mesh.mesh, (1.0, 0.0, 1.0, 1.0))
    no_force = fem.Constant(mesh.mesh, (0.0, 0.0, 0.0))
    layer = SolidLayer(energy, natural, no_force)
    return Solid(mesh, [layer], pressure_scale=YOUNG * 1e3)


def _supports(solid: Solid) -> list[fem.DirichletBC]:
    """Return the hinges and the planes of symmetry."""
    edge = on_cylinder(np.array([[RADIUS * HALF_ANGLE, 0.0]]))[0]
    hinges = [
        held_where(
            solid, axis, lambda x: np.isclose(x[0], edge[0]) & np.isclose(x[2], edge[2], atol=1e-9)
        )
        for axis in range(3)
    ]
    planes = [
        held_where(solid, axis, lambda x, axis=axis: np.isclose(x[axis], 0)) for axis in (0, 1)
    ]
    return [*hinges, *planes]
