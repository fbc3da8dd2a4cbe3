"""The flow to a stable equilibrium, through a snap (clamped plate)."""

import pytest

pytest.importorskip("dolfinx")

from verification.buckled_plate import BuckledPlate
from verification.solid_problem import push

from bilayer.errors import ComputationError
from bilayer.solvers.path import follow_path
from fenics_model.branches.gradient_flow import FlowRule, GradientFlow
from fenics_model.branches.stability import unstable_modes
from fenics_model.path.continuation import Continuation, Tolerances
from fenics_model.path.predictor import Predictor
from fenics_model.path.step_control import StepControl

PUSH = 5e4  # N/m3, beyond the limit point at about 3e4


@pytest.fixture
def plate():
    plate = BuckledPlate()
    yield plate
    plate.close()


@pytest.mark.mpi
def test_a_flow_ends_at_a_stable_equilibrium_and_takes_the_energy_that_is_lost(plate):
    flowed = plate.flow_to_equilibrium(plate.flat + plate.lift(1e-2))
    assert flowed.equilibrium is not None
    found = flowed.equilibrium.state
    assert plate.newton.residual_norm(found) <= plate.tolerance
    assert plate.unstable_modes(found) == 0
    assert plate.rise(found) > 1e-4  # to the side to which it was disturbed
    # what the viscosity took is what the plate lost, but for the first-order time steps
    lost = plate.energy(plate.flat) - plate.energy(found)
    assert 0 < flowed.effort.dissipated < 2 * lost


def snap(plate, step_limit):
    """Buckle the plate upward, then push it down until it snaps; return the load steps' points."""
    buckled = plate.flow_to_equilibrium(plate.flat + plate.lift(1e-2)).state
    path = Continuation(
        plate.newton,
        plate.search(step_limit=step_limit),
        lambda parameter: push(plate.solid, -PUSH * parameter),
        StepControl(0.2, 0.01, 0.2, 6),
        Tolerances(1e-10, 1e-4, plate.reference),
    )
    path.predictor = Predictor([(0.0, buckled)])
    return list(follow_path(path, [1.0]))


@pytest.mark.mpi
def test_a_snap_is_passed_by_the_flow_and_the_branch_behind_it_is_stable(plate):
    steps = snap(plate, step_limit=100)
    first, last = steps[0].point, steps[-1].point
    assert steps[-1].is_at_target
    assert last.unstable_modes == 0
    assert last.residual <= 1e-10
    assert plate.rise(first.state) > 1e-4 > -1e-4 > plate.rise(last.state)
    assert steps[-1].effort.flow_steps > 0
    assert steps[-1].effort.dissipated > 0


@pytest.mark.mpi
def test_without_the_flow_the_path_ends_at_the_limit_point(plate):
    *_, before, last = snap(plate, step_limit=0)
    assert isinstance(last.failure, ComputationError)
    assert "no convergence" in str(last.failure)
    assert last.point.state is before.point.state  # not what the failed attempt left
    assert 0 < last.point.share < 1
    assert last.point.effort.iterations > 0


def test_a_second_tangent_leads_farther_on_the_way_to_the_same_place(plate):
    """From flat the plate bends far along a curve."""

    def flow(tangents):
        rule = FlowRule(tangents=tangents)
        flow = GradientFlow(plate.newton, first_viscosity=1e12, escape=1e-4, rule=rule)
        start = plate.flat + plate.lift(1e-2)
        return flow.flow_to_equilibrium(start, plate.tolerance, plate.reference)

    many, one = flow(4), flow(1)
    assert many.state.values == pytest.approx(one.state.values, abs=1e-9)
    assert many.effort.flow_steps < one.effort.flow_steps


def test_a_body_at_rest_in_an_unstable_equilibrium_is_put_beside_it(plate):
    """Out of round-off the plate would bend as slowly as an exponential grows."""

    def flow(escape):
        flow = GradientFlow(plate.newton, first_viscosity=1e12, escape=escape)
        start = plate.flat + plate.lift(1e-10)
        return flow.flow_to_equilibrium(start, plate.tolerance, plate.reference)

    beside, slowly = flow(1e-4), flow(0.0)
    assert slowly.equilibrium is not None
    assert plate.unstable_modes(beside.state) == 0
    assert plate.energy(beside.state) == pytest.approx(plate.energy(slowly.state), rel=1e-9)
    assert beside.effort.flow_steps < slowly.effort.flow_steps - 10


def test_the_missing_viscosity_of_an_unstable_tangent_is_found(plate):
    """With a little more than that no mode is unstable, with a little less one still is."""
    flow = GradientFlow(plate.newton, first_viscosity=1e12, escape=1e-4)
    with plate.newton.factorise(plate.flat) as factors:
        modes = unstable_modes(factors, plate.solid.number_of_pressures)
        mode = flow.most_unstable_mode(factors, modes, plate.flat + plate.lift(1e-2))
    assert modes > 0
    assert mode is not None
    missing = -mode.stiffness
    for share, is_stable in ((0.99, False), (1.01, True)):
        with (
            plate.newton.slow_down(share * missing, plate.flat),
            plate.newton.factorise(plate.flat) as factors,
        ):
            left = unstable_modes(factors, plate.solid.number_of_pressures)
        assert (left == 0) == is_stable


def test_the_lowest_state_is_found(plate):
    flow = GradientFlow(plate.newton, first_viscosity=1e12, escape=1e-4)
    states = [plate.flat + plate.lift(height) for height in (1e-3, 1e-4, 1e-2)]
    energies = [plate.energy(state) for state in states]
    assert flow.lowest(states) is states[energies.index(min(energies))]
