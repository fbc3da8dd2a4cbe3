"""A shell's equations near an equilibrium: its factorised stiffness, and what they depend on.

Derivatives by a parameter are central differences of forces and positions at the fixed state, with
the specimen changed a little (`bilayer.solvers.parameters`): no iteration, so no noise.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.alignment import align_gradient
from bilayer.mesh.planar import flat_surface
from bilayer.solvers.parameters import difference_by
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair, stretch_of
from bilayer.specimen.specimen import Specimen
from dshell.energies.assembly import Assembly
from dshell.models.morley import MorleyModel
from dshell.models.reference_surface import (
    reference_surface_flat_gradient,
    reference_surface_gradient,
)
from dshell.release.specimen_shell import SpecimenShell
from dshell.solve.linear_solver import Factor, NotPositiveDefiniteError, best_linear_solver
from dshell.solve.newton import Configuration

Array = NDArray[np.float64]

SMALL_CHANGE = 1e-6
"""Of the largest coordinate, for the change of the position with the state."""


class LinearisedShell:
    """See `bilayer.solvers.contract.Linearised`.

    Parameters
    ----------
    shell : SpecimenShell
        The specimen.
    assembly : Assembly
        Of its energies.
    milestone : tuple of float
        The prestretch and the loads.
    state : (dofs,) array of float
        The equilibrium, m.
    """

    def __init__(
        self, shell: SpecimenShell, assembly: Assembly, milestone: Milestone, state: Array
    ) -> None:
        self._shell, self._milestone, self._state = shell, milestone, state
        self._free = assembly.free
        self._factor = _factor_of(Configuration(shell.body(milestone), state, assembly))

    def solve(self, right_side: Array) -> Array:
        """Return the solution of stiffness x = right side, m; 0 where the shell is held."""
        solution = np.zeros_like(self._state)
        solution[self._free] = self._factor.solve(np.ascontiguousarray(right_side[self._free]))
        return solution

    def residual_by(self, parameter: str) -> Array:
        """Return the derivative of the residual force by a parameter, (dofs,)."""
        return self._difference(
            lambda shell, milestone: shell.forces(milestone, self._state), parameter
        )

    def position_by(self, parameter: str) -> Array:
        """Return the derivative of the position by a parameter, the state fixed, (n, 3)."""
        return self._difference(
            lambda shell, milestone: shell.position(milestone, self._state), parameter
        )

    def state_gradient(self, position_gradient: Array) -> Array:
        """Return the gradient by the state of a function of the position, (dofs,)."""
        shell, milestone = self._shell, self._milestone
        mesh = shell.mesh
        by_surface = reference_surface_gradient(
            shell.surface(self._state),
            mesh.triangles,
            mesh.areas,
            shell.model.reference_height(stretch_of(milestone)),
            self._before_alignment(position_gradient),
        )
        by_state = np.zeros_like(self._state)
        by_state[: by_surface.size] = by_surface.reshape(-1)
        by_state[shell.held] = 0.0
        return by_state

    def points_gradient(self, adjoint: Array, position_gradient: Array) -> Array:
        """Return a gradient by the flat places of the nodes; see `ShapeLinearised`.

        Its part through the residual is d/de of the energy's derivative by the places, the state
        being moved by e times the adjoint: two evaluations for all nodes.
        """
        shell, state = self._shell, self._state
        model, stretch = shell.model, stretch_of(self._milestone)
        if not isinstance(model, MorleyModel) or shell.specimen.is_placed or shell.has_contact:
            raise InputError(
                "points_gradient: expected the shell 'morley' without gravity, loads and contact"
            )
        mesh = shell.mesh
        by_surface = reference_surface_flat_gradient(
            shell.surface(state),
            mesh.triangles,
            mesh.points,
            model.reference_height(stretch),
            self._before_alignment(position_gradient),
        )
        length = np.abs(adjoint).max()
        if length == 0:
            return by_surface
        step = SMALL_CHANGE * np.abs(state).max() / length
        ahead, behind = (
            model.flat_gradient(stretch, state + sign * step * adjoint) for sign in (1.0, -1.0)
        )
        return np.asarray(by_surface - (ahead - behind) / (2 * step))

    def residual_along(self, velocity: Array) -> Array:
        """Return the derivative of the residual as the nodes of the flat sheet move, (dofs,)."""
        return self._along(velocity, lambda shell: shell.forces(self._milestone, self._state))

    def position_along(self, velocity: Array) -> Array:
        """Return the derivative of the position as the nodes of the flat sheet move, (n, 3)."""
        return self._along(velocity, lambda shell: shell.position(self._milestone, self._state))

    def _along(self, velocity: Array, value: Callable[[SpecimenShell], Array]) -> Array:
        """Return the central difference of a function of the shell on a moving mesh."""
        points = self._shell.mesh.points
        length = np.abs(velocity).max()
        if length == 0:
            return np.zeros_like(value(self._shell))
        step = SMALL_CHANGE * np.abs(points).max() / length
        ahead, behind = (
            value(self._shell.on(self._shell.mesh.with_points(points + sign * step * velocity)))
            for sign in (1.0, -1.0)
        )
        return np.asarray((ahead - behind) / (2 * step))

    def _before_alignment(self, position_gradient: Array) -> Array:
        """Return the gradient by the reference surface where the nodes are held, (n, 3)."""
        shell, flat = self._shell, flat_surface(self._shell.mesh)
        if shell.specimen.is_placed:
            return position_gradient
        shape = shell.reference_surface(self._milestone, self._state)
        return align_gradient(shape, flat.points, flat.node_areas, position_gradient)

    def position_change(self, state_change: Array) -> Array:
        """Return the change of the position with the state, (n, 3), m: a central difference."""
        length = np.abs(state_change).max()
        if length == 0:
            return np.zeros_like(self._shell.surface(self._state))
        step = SMALL_CHANGE * np.abs(self._state).max() / length
        ahead, behind = (
            self._shell.position(self._milestone, self._state + sign * step * state_change)
            for sign in (1.0, -1.0)
        )
        return np.asarray((ahead - behind) / (2 * step))

    def _difference(
        self, value: Callable[[SpecimenShell, Milestone], Array], parameter: str
    ) -> Array:
        stretch, loads = stretch_of(self._milestone), self._milestone[2:]

        def of(specimen: Specimen, stretch: StretchPair) -> Array:
            return value(self._shell.of(specimen), (*stretch, *loads))

        return difference_by(of, self._shell.specimen, stretch, parameter)


def _factor_of(here: Configuration) -> Factor:
    """Return a factor of the stiffness that no other solver takes away."""
    stiffness = here.hessian()
    linear_solver = best_linear_solver()
    try:
        return linear_solver.cholesky(stiffness)
    except NotPositiveDefiniteError:
        return linear_solver.factor(stiffness)
