"""The barrier of a solid's skin as a force beside its own; see `solve.newton.AddedForce`."""

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_model.contact.surface_contact import SurfaceContact
from fenics_model.solid.state import State

Array = NDArray[np.float64]


class BarrierForce:
    """The barrier with its exact derivatives.

    Parameters
    ----------
    contact : SurfaceContact
        Of the solid.
    """

    def __init__(self, contact: SurfaceContact) -> None:
        self._contact = contact

    def force(self, state: State) -> Array:
        """See `AddedForce`."""
        return self._contact.by_dofs(state, self._contact.at(state).gradient)

    def stiffness(self, state: State, held: NDArray[np.int32]) -> PETSc.Mat | None:
        """See `AddedForce`."""
        found = self._contact.at(state)
        return self._contact.stiffness(found.hessian(), held) if found.pairs else None


class ConvexBarrierForce(BarrierForce):
    """The barrier with a tangent that has no negative eigenvalue."""

    def stiffness(self, state: State, held: NDArray[np.int32]) -> PETSc.Mat | None:
        """See `AddedForce`."""
        found = self._contact.at(state)
        return self._contact.stiffness(found.convex_hessian(), held) if found.pairs else None


class LinearisedBarrierForce:
    """The barrier linearised in one state: springs between the places that touch there.

    Parameters
    ----------
    contact : SurfaceContact
        Of the solid.
    origin : State
        Where.
    """

    def __init__(self, contact: SurfaceContact, origin: State) -> None:
        self._contact, self._points = contact, contact.points(origin)
        touching = contact.at(origin)
        self._gradient, self._hessian = touching.gradient, touching.convex_hessian()

    def force(self, state: State) -> Array:
        """See `AddedForce`."""
        moved = self._contact.points(state) - self._points
        change = (self._hessian @ moved.reshape(-1)).reshape(-1, 3)
        return self._contact.by_dofs(state, self._gradient + change)

    def stiffness(self, state: State, held: NDArray[np.int32]) -> PETSc.Mat | None:
        """See `AddedForce`."""
        return self._contact.stiffness(self._hessian, held)
