"""The equations of the solid near an equilibrium: its factorised tangent, what a parameter does."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bilayer.solvers.parameters import difference_by, parameter_value
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen
from fenics_model.path.load_schedule import LoadPlace
from fenics_model.release.specimen_solid import SpecimenSolid
from fenics_model.solid.numbering import Numbering
from fenics_model.solid.state import State
from fenics_model.solve.newton import Newton

Array = NDArray[np.float64]


SMALL_CHANGE = 1e-6
"""Of the largest coordinate, for the motion of the nodes."""


class SolidLinearisation:
    """See `bilayer.solvers.contract.ShapeLinearised`; all vectors are those of `Numbering`.

    The state is the displacement of a mesh that is drawn as thick as the layers naturally are, and
    the reference surface stays where it is drawn. So no parameter moves it while the state is
    fixed.

    Parameters
    ----------
    body : SpecimenSolid
        The solid and its specimen.
    newton : Newton
        Solves.
    numbering : Numbering
        Of the dofs.
    state : State
        The equilibrium.
    place : LoadPlace
        Its loads.
    """

    def __init__(
        self,
        body: SpecimenSolid,
        newton: Newton,
        numbering: Numbering,
        state: State,
        place: LoadPlace,
    ) -> None:
        self._body, self._newton, self._numbering = body, newton, numbering
        self._state, self._place = state, place
        self._factors = newton.factorise(state)

    def solve(self, right_side: Array) -> Array:
        """Return the solution of tangent x = right side."""
        held = self._newton.held_dofs
        side = self._numbering.spread(right_side)
        side[held] = 0.0
        return self._numbering.gather(self._factors.solve(side))

    def residual_by(self, parameter: str) -> Array:
        """Return the derivative of the residual by a parameter, the state fixed."""
        return difference_by(self._residual, self._body.specimen, self._place.stretch, parameter)

    def _residual(self, specimen: Specimen, stretch: StretchPair) -> Array:
        place = replace(self._place, stretch=stretch)
        with self._body.use_specimen(specimen, place):
            return self._numbering.gather(self._newton.residual(self._state))

    def position_by(self, parameter: str) -> Array:
        """Return the derivative of the reference surface by a parameter, the state fixed: zero."""
        parameter_value(self._body.specimen, self._place.stretch, parameter)  # it has to be one
        return np.zeros((len(self._body.mesh.points), 3))

    def state_gradient(self, position_gradient: Array) -> Array:
        """Return the gradient by the state of a function of the reference surface."""
        gradient = np.zeros(self._numbering.size)
        gradient[self._surface] = position_gradient
        return gradient

    def position_change(self, state_change: Array) -> Array:
        """Return the change of the reference surface with the state, (n, 3), m."""
        return np.asarray(state_change[self._surface])

    def residual_along(self, velocity: Array) -> Array:
        """Return the derivative of the residual as the nodes of the flat sheet move, (dofs,).

        All levels of the mesh move with their planar nodes.
        """
        volume = self._body.solid.mesh.volume
        length = np.abs(velocity).max()
        if length == 0:
            return np.zeros(self._numbering.size)
        step = SMALL_CHANGE * np.abs(volume.points).max() / length
        motion = step * _in_space(velocity)[volume.planar_nodes]
        ahead, behind = (
            self._residual_drawn_at(volume.points + sign * motion) for sign in (1.0, -1.0)
        )
        return np.asarray((ahead - behind) / (2 * step))

    def _residual_drawn_at(self, points: Array) -> Array:
        with self._body.solid.mesh.drawn_at(points):
            return self._numbering.gather(self._newton.residual(self._state))

    def position_along(self, velocity: Array) -> Array:
        """Return the derivative of the position as the nodes move, their displacements fixed."""
        return _in_space(velocity)

    @property
    def _surface(self) -> NDArray[np.int64]:
        return self._numbering.displacements_at(self._body.solid.mesh.volume.reference_surface)


def _in_space(velocity: Array) -> Array:
    """Return velocities in the plane, (n, 2), as those of points in space, (n, 3)."""
    return np.column_stack([velocity, np.zeros(len(velocity))])
