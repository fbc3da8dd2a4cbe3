"""A thin plate clamped at both ends and compressed: flat it is in balance, but unstable."""

import numpy as np
from dolfinx import fem

from bilayer import MooneyRivlin
from verification.solid_problem import (
    count_modes,
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
    """The plate; close it.

    Parameters
    ----------
    compression : float
        Natural length over the distance of the clamps.

    Attributes
    ----------
    flat : State
        Its flat equilibrium.
    """

    def __init__(self, compression: float = COMPRESSION) -> None:
        self.solid = solid_of(stacked(rectangle(LENGTH, WIDTH, 4, 2), [THICKNESS]), [MATERIAL])
        ends = [
            held_where(self.solid, axis, lambda x: np.isclose(x[0] * (LENGTH - x[0]), 0))
            for axis in (0, 1, 2)
        ]
        self.newton = newton_of(self.solid, ends)
        self.solid.layers[0].natural.value = (compression, 0.0, 1.0, 1.0)
        self.reference = self.newton.residual_norm(self.solid.undeformed)
        self.tolerance = 1e-10 * self.reference
        self.flat = self.solved(self.solid.undeformed)

    def close(self):
        self.newton.close()

    def solved(self, guess):
        """The equilibrium that Newton's method finds from a guess."""
        outcome = self.newton.solve(guess, self.tolerance)
        assert outcome.converged, outcome.reason
        return outcome.state

    def lift(self, height):
        """A change of the state: a parabola up, of a height over the length."""
        return self.solid.interpolate(
            lambda x: np.stack([0 * x[0], 0 * x[0], height * x[0] * (1 - x[0] / LENGTH)])
        ).values

    def search(self, **options):
        """A search for branches whose side "plus" is up."""
        return search_of(self.newton, lambda x: x[0] * (1 - x[0] / LENGTH), **options)

    def leave(self, state, search):
        """The outcome of a search from an unstable equilibrium."""
        with self.newton.factorise(state) as factors:
            return search.leave_unstable(state, factors, self.tolerance, self.reference)

    def flow_to_equilibrium(self, start, step_limit=100):
        """The end of the flow from a state."""
        flow = self.search(step_limit=step_limit).flow
        return flow.flow_to_equilibrium(start, self.tolerance, self.reference)

    def unstable_modes(self, state):
        return count_modes(self.newton, state)

    def energy(self, state):
        return self.solid.potential_energy(state)

    def relaxed_energy(self, state):
        """Potential energy of the displacements of a state, in balance inside.

        The pressures follow: the energy is a maximum in them.
        """
        here = self.solid.function_of(state)
        held = [
            fem.dirichletbc(here, np.unique(self.solid.component(axis).dofmap.list))
            for axis in range(3)
        ]
        with newton_of(self.solid, held) as newton:
            return self.energy(newton.solve(state, self.tolerance).state)

    def rise(self, state):
        """Mean height of the vertices, m."""
        return self.solid.vertex_displacements(state)[:, 2].mean()
