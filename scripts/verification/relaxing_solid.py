"""A block of the finite-element model that relaxes: uniform states in time. SI units."""

from collections.abc import Iterator, Sequence

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI

from bilayer.specimen.relaxation import PronySeries
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.solid.memory import DeadStresses, SolidMemory
from fenics_model.solid.solid import Solid, SolidLayer
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import energy_constants
from verification.solid_problem import held_where, mean, newton_of, push, rectangle, stacked

SIDE, THICKNESS = 2e-3, 1e-3
DEGREE = 4
TWO_TERMS = PronySeries(((0.4, 0.7), (0.3, 20.0)))
ONE_TERM = PronySeries(((0.6, 10.0),))
TINY = 1e-7
"""Strain of a block that creeps, so that its answer is that of small strain."""
TOLERANCE = 1e-12


class RelaxingBlock:
    """One layer that relaxes, of few elements.

    Parameters
    ----------
    law : Law
        Its instantaneous one.
    series : PronySeries
        How it relaxes.
    """

    def __init__(self, law, series: PronySeries) -> None:
        mesh = LayeredMesh(stacked(rectangle(SIDE, SIDE, 1, 1), [THICKNESS]), MPI.COMM_SELF)

        def constant(value):
            return fem.Constant(mesh.mesh, np.asarray(value, dtype=default_scalar_type))

        kind, values = energy_constants(law)
        energy = kind(**{name: constant(value) for name, value in values.items()})
        dead = DeadStresses(mesh, DEGREE)
        force = ufl.as_vector((0, 0, constant(0.0)))
        layer = SolidLayer(energy, constant((1.0, 0.0, 1.0, 1.0)), force, dead.of_layer())
        self.law, self.series = law, series
        self.solid = Solid(
            mesh, [layer], pressure_scale=law.shear_modulus / 1e-3, quadrature_degree=DEGREE
        )
        self.memory = SolidMemory(self.solid, dead, {0: series}, hold=0.0)

    def unstrained(self, number: int):
        """Return the stresses of a layer that was held without a strain: none."""
        return np.zeros((7, 1, 1))

    def _take_steps(self, newton, steps: Sequence[float]) -> Iterator[State]:
        """Yield the equilibrium at time 0 and at the end of each step."""
        state, time = self.solid.undeformed, 0.0
        for step in (0.0, *steps):
            time += step
            self.memory.aim_at(time, self.unstrained)
            outcome = newton.solve(state, TOLERANCE)
            assert outcome.converged, outcome.reason
            state = outcome.state
            self.memory.arrive(state, self.unstrained)
            yield state

    def held(self, stretch: float, steps: Sequence[float]) -> list[float]:
        """Return the nominal stress of the block stretched along x at once and held, Pa.

        At time 0 and after each step; the sides of the block are free.
        """
        solid, layer = self.solid, self.solid.layers[0]
        held = [held_where(solid, a, lambda x, a=a: np.isclose(x[a], 0.0)) for a in range(3)]
        moved = (stretch - 1) * SIDE
        held.append(held_where(solid, 0, lambda x: np.isclose(x[0], SIDE), moved))
        nominal = (solid.gradient * layer.stress(solid.gradient, solid.pressures[0]))[0, 0]
        with newton_of(solid, held, iteration_limit=30) as newton:
            return [mean(solid, state, nominal) for state in self._take_steps(newton, steps)]

    def creep(self, end: float, count: int) -> np.ndarray:
        """Return the sag of the block under its weight over that at time 0, count even steps."""
        force = TINY * self.law.shear_modulus / THICKNESS
        push(self.solid, -force)
        top = [held_where(self.solid, axis, lambda x: np.isclose(x[2], 0.0)) for axis in range(3)]
        steps = [end / count] * count
        with newton_of(self.solid, top, iteration_limit=30) as newton:
            sags = [
                self.solid.displacement_norm(state.values)
                for state in self._take_steps(newton, steps)
            ]
        push(self.solid, 0.0)
        return np.array(sags) / sags[0]


def exact_creep(time, series: PronySeries):
    """Return the strain under a load that stays, over that at time 0, of a series of one term."""
    (_, tau), relaxed = series.terms[0], series.relaxed_share
    return 1 + (1 / relaxed - 1) * (1 - np.exp(-relaxed * time / tau))
