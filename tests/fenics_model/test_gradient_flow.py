"""The flow to a stable equilibrium, through a snap (clamped plate)."""

import pytest

pytest.importorskip("dolfinx")

from verification.buckled_plate import BuckledPlate
from verification.solid_problem import push, unguided

from fenics_model.path.continuation import PathError, Tolerances, follow
from fenics_model.path.step_control import StepControl


@pytest.mark.mpi
def test_a_flow_ends_at_a_stable_equilibrium_and_takes_the_energy_that_is_lost():
    plate = BuckledPlate()
    flat = plate.energy()
    plate.solid.state.x.array[:] += plate.lift(1e-2)
    flowed = plate.search().flow.relax(plate.tolerance, plate.reference)
    assert flowed.equilibrium is not None
    assert plate.newton.residual_norm() <= plate.tolerance
    assert plate.search().flow.unstable_modes() == 0
    assert plate.rise() > 1e-4  # to the side to which it was disturbed
    # what the viscosity took is what the plate lost, but for the first-order time steps
    assert plate.energy() < flat
    assert 0 < flowed.effort.dissipated < 2 * (flat - plate.energy())
    plate.newton.destroy()


def snap(step_limit):
    """Buckle the plate upward, then push it down until it snaps; return it and the equilibria."""
    plate = BuckledPlate()
    plate.solid.state.x.array[:] += plate.lift(1e-2)
    assert plate.search().flow.relax(plate.tolerance, plate.reference).equilibrium
    control = StepControl(0.2, 0.01, 0.2, 6)
    equilibria = []
    try:
        for equilibrium in follow(
            plate.newton,
            plate.search(step_limit=step_limit),
            lambda parameter: push(plate.solid, -PUSH * parameter),
            [1.0],
            control,
            Tolerances(1e-10, 1e-4, plate.reference),
            unguided(plate.solid, plate.newton),
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
