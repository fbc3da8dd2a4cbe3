"""A thin plate clamped at both ends and compressed: flat it is in balance, but unstable."""

import numpy as np
from dolfinx import fem

from bilayer import MooneyRivlin
from verification.solid_problem import (
    held_where,
    newton_of,
    rectangle,
    search_of,
    solid_of,
    stacked,
)

LENGTH, WIDTH, THICKNESS, COMPRESSION = 8e-3, 4e-3, 1e-3, 0.93
MATERIAL = MooneyRivlin(4839.1, 14536.0, 1e-6)


class BuckledPlate:
    """The plate, in its flat equilibrium when it is made.

    Parameters
    ----------
    compression : float
        Natural length over the distance of the clamps.
    """

    def __init__(self, compression: float = COMPRESSION) -> None:
        self.solid = solid_of(stacked(rectangle(LENGTH, WIDTH, 4, 2), [THICKNESS]), [MATERIAL])
        ends = [
            held_where(self.solid, axis, lambda x: np.isclose(x[0] * (LENGTH - x[0]), 0))
            for axis in (0, 1, 2)
        ]
        self.newton = newton_of(self.solid, ends)
        self.solid.layers[0].natural.value = (compression, 1.0, 1.0)
        self.reference = self.newton.residual_norm()
        self.tolerance = 1e-10 * self.reference
        self.solved()

    def solved(self):
        """Solve from the present state; it must converge."""
        outcome = self.newton.solve(self.tolerance)
        assert outcome.converged, outcome.reason
        return outcome

    def lift(self, height):
        """A change of the state: a parabola up, of a height over the length."""
        lift = fem.Function(self.solid.space)
        lift.sub(0).interpolate(
            lambda x: np.stack([0 * x[0], 0 * x[0], height * x[0] * (1 - x[0] / LENGTH)])
        )
        return lift.x.array

    def search(self, **options):
        """A search for branches whose side "plus" is up."""
        return search_of(self.solid, self.newton, lambda x: x[0] * (1 - x[0] / LENGTH), **options)

    def energy(self):
        return self.solid.potential_energy()

    def energy_at(self, change):
        """Potential energy of the present displacements and a change of them, in balance inside.

        The pressures follow: the energy is a maximum in them.
        """
        state = self.solid.state
        kept = state.x.array.copy()
        state.x.array[:] += change
        here = state.copy()
        held = [
            fem.dirichletbc(here, np.unique(self.solid.component(axis).dofmap.list))
            for axis in range(3)
        ]
        newton = newton_of(self.solid, held)
        newton.solve(self.tolerance)
        newton.destroy()
        energy = self.energy()
        state.x.array[:] = kept
        return energy

    def rise(self):
        """Mean height of the vertices, m."""
        return self.solid.vertex_displacements()[:, 2].mean()
