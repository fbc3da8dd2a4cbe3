"""The flow to a stable equilibrium: off an unstable one, and through a snap (clamped plate)."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from dolfinx import fem
from solids import flow_of, held_where, newton_of, push, rectangle, solid_of, stacked

from bilayer import MooneyRivlin
from fenics_model.continuation import PathError, Tolerances, follow
from fenics_model.step_control import StepControl

LENGTH, COMPRESSION = 8e-3, 0.93


class Plate:
    """A thin plate clamped at both ends and compressed: flat it is in balance, but unstable."""

    def __init__(self, step_limit=100):
        volume = stacked(rectangle(LENGTH, 4e-3, 4, 2), [1e-3])
        self.solid = solid_of(volume, [MooneyRivlin(4839.1, 14536.0, 1e-6)])
        ends = [
            held_where(self.solid, axis, lambda x: np.isclose(x[0] * (LENGTH - x[0]), 0))
            for axis in (0, 1, 2)
        ]
        self.newton = newton_of(self.solid, ends)
        lift = fem.Function(self.solid.space)
        lift.sub(0).interpolate(
            lambda x: np.stack([0 * x[0], 0 * x[0], 1e-2 * x[0] * (1 - x[0] / LENGTH)])
        )
        self.flow = flow_of(self.solid, self.newton, lift.x.array, step_limit)
        self.solid.layers[0].natural.value = (COMPRESSION, 1.0, 1.0)
        self.reference = self.newton.residual_norm()
        assert self.newton.solve(1e-10 * self.reference).converged

    def energy(self):
        return self.solid.layer_energy(0)

    def rise(self):
        """Mean height of the vertices."""
        return self.solid.vertex_displacements()[:, 2].mean()


@pytest.mark.mpi
def test_an_unstable_equilibrium_is_left_for_a_stable_one_of_less_energy():
    plate = Plate()
    assert plate.flow.unstable_modes() > 0
    flat = plate.energy()
    left = plate.flow.escape(1e-10 * plate.reference, plate.reference)
    assert left.equilibrium is not None
    assert left.effort.escapes == 1
    assert plate.newton.residual_norm() <= 1e-10 * plate.reference
    assert plate.flow.unstable_modes() == 0
    assert plate.rise() > 1e-4  # to the side to which it was disturbed
    # what the viscosity took is what the plate lost, but for the first-order time steps
    assert plate.energy() < flat
    assert 0 < left.effort.dissipated < 2 * (flat - plate.energy())
    plate.newton.destroy()


@pytest.mark.mpi
def test_a_flow_that_may_take_no_step_leaves_the_state():
    plate = Plate(step_limit=0)
    before = plate.solid.state.x.array.copy()
    left = plate.flow.escape(1e-10 * plate.reference, plate.reference)
    assert left.equilibrium is None
    assert plate.solid.state.x.array == pytest.approx(before, abs=0)
    plate.newton.destroy()


def snap(step_limit):
    """Buckle the plate upward, then push it down until it snaps; return it and the equilibria."""
    plate = Plate()
    assert plate.flow.escape(1e-10 * plate.reference, plate.reference).equilibrium
    plate.flow._step_limit = step_limit
    control = StepControl(0.2, 0.01, 0.2, 6)
    equilibria = []
    try:
        for equilibrium in follow(
            plate.newton,
            plate.flow,
            lambda parameter: push(plate.solid, -PUSH * parameter),
            [1.0],
            control,
            Tolerances(1e-10, 1e-4, plate.reference),
        ):
            equilibria.append((equilibrium, plate.rise()))
    finally:
        plate.newton.destroy()
    return equilibria


PUSH = 5e4  # N/m3, beyond the limit point at about 3e4


@pytest.mark.mpi
def test_a_snap_is_passed_by_the_flow_and_the_branch_behind_it_is_stable():
    equilibria = snap(step_limit=100)
    last, rise = equilibria[-1]
    assert last.milestone == 0
    assert last.unstable_modes == 0
    assert last.residual <= 1e-10
    assert equilibria[0][1] > 1e-4 > -1e-4 > rise
    assert sum(equilibrium.effort.flow_steps for equilibrium, _ in equilibria) > 0
    assert sum(equilibrium.effort.dissipated for equilibrium, _ in equilibria) > 0


@pytest.mark.mpi
def test_without_the_flow_the_path_ends_at_the_limit_point():
    with pytest.raises(PathError, match="no convergence"):
        snap(step_limit=0)
