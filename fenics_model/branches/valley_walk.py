"""A walk off an unstable equilibrium: along its mode, everything else in balance.

The energy is minimised with the distance along a direction d held at a, that is

    R(x) = s M d,   d . M (x - x0) = a (d . M d),

by Newton's method on the bordered system: the factors of the tangent and two right-hand sides
(W. Wagner, P. Wriggers, Engineering Computations 5 (1988) 103-109). Without the soft direction that
is well posed, also where the tangent is singular. The multiplier s is the slope of the energy along
the walk: it is negative on the way down, and zero at the next equilibrium.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from petsc4py import PETSc

from fenics_model.solve.newton import Newton

GROWTH, CUT = 2.0, 4.0
"""Factors of the step after a success and after a failure."""

FARTHEST = 2000.0
"""Over the first distance: where a walk that still leads down is given up."""

ITERATION_LIMIT, CUTS = 8, 1
"""Iterations at a place after which it has failed; failed places after which the walk ends.

The valley may turn away from the straight direction; then there is no place farther out.
"""

ACCURACY = 1e-3
"""The residual that is left, over the force that holds the distance."""


@dataclass(frozen=True)
class _Place:
    """Where the energy is minimal at a distance; x and its change with the distance."""

    distance: float
    x: PETSc.Vec
    tangent: PETSc.Vec
    slope: float


class ValleyWalk:
    """Walks from the solver's present state, an unstable equilibrium.

    Parameters
    ----------
    newton : Newton
        Holds the state.
    mass : PETSc Mat
        M, zero for pressures and held dofs.
    direction : array of float
        d, this rank's own dofs.
    tolerance : float
        Norm of the residual of an equilibrium, N; no place is solved more accurately.

    Attributes
    ----------
    iterations : int
        Factorisations so far.
    """

    def __init__(
        self, newton: Newton, mass: PETSc.Mat, direction: NDArray[np.float64], tolerance: float
    ) -> None:
        self._newton, self._tolerance = newton, tolerance
        self._origin = newton.vector()
        along = self._origin.duplicate()
        along.array[:] = direction
        self._force = self._origin.duplicate()
        mass.mult(along, self._force)
        self._square = float(self._force.dot(along))
        self._start = _Place(0.0, self._origin, along, 0.0)
        self.iterations = 0

    def descend(self, first_distance: float) -> bool:
        """Walk down until the energy rises again; leave the state near where it is least.

        Returns
        -------
        bool
            Whether the walk came to such a place; if not, the state is the lowest one on the way.
        """
        here, step, cuts = self._start, first_distance, 0
        while here.distance < FARTHEST * first_distance and cuts <= CUTS:
            there = self._place(here, here.distance + step)
            if there is None:
                step, cuts = step / CUT, cuts + 1
                continue
            if there.slope > 0:
                self._newton.move_to(_between(here, there))
                return True
            here, step = there, GROWTH * step
        self._newton.move_to(here.x)
        return False

    def _place(self, here: _Place, distance: float) -> _Place | None:
        """Solve at a distance, from the tangent at another place; None if that fails."""
        newton, x = self._newton, here.x.copy()
        x.axpy(distance - here.distance, here.tangent)
        slope = here.slope
        for _ in range(ITERATION_LIMIT):
            newton.move_to(x)
            self.iterations += 1
            if newton.factorise().getFailedReason():
                return None
            elastic, held = newton.corrections(newton.residual(), self._force)
            off = x.copy()
            off.axpy(-1.0, self._origin)
            gap = distance * self._square - float(self._force.dot(off))
            compliance = float(self._force.dot(held))
            slope = (gap + float(self._force.dot(elastic))) / compliance
            x.axpy(-1.0, elastic)
            x.axpy(slope, held)
            newton.move_to(x)
            left = newton.residual()
            left.axpy(-slope, self._force)
            holding = abs(slope) * float(self._force.norm())
            norm = float(left.norm())
            if not np.isfinite(norm):
                return None
            if norm <= max(self._tolerance, ACCURACY * holding):
                held.scale(self._square / compliance)
                return _Place(distance, x, held, slope)
        return None


def _between(before: _Place, after: _Place) -> PETSc.Vec:
    """Guess the state where the slope is zero: cubic Hermite interpolation between two places."""
    span = after.distance - before.distance
    share = before.slope / (before.slope - after.slope)
    x = before.x.copy()
    x.scale((1 + 2 * share) * (1 - share) ** 2)
    x.axpy(share * (1 - share) ** 2 * span, before.tangent)
    x.axpy(share**2 * (3 - 2 * share), after.x)
    x.axpy(share**2 * (share - 1) * span, after.tangent)
    return x
