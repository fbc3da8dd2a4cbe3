"""The energy of the displacements alone, by which the flow judges its steps (clamped plate)."""

from contextlib import contextmanager

import pytest

pytest.importorskip("dolfinx")

import numpy as np
from verification import buckled_plate
from verification.buckled_plate import BuckledPlate

from bilayer import MooneyRivlin
from fenics_model.branches.condensed_energy import CondensedEnergy
from fenics_model.branches.gradient_flow import FlowRule, ViscosityControl


@contextmanager
def balanced_plate():
    plate = BuckledPlate()
    try:
        with CondensedEnergy(plate.newton).at_present_loads() as balance:
            yield plate, balance
    finally:
        plate.close()


@pytest.fixture
def plate_and_balance():
    with balanced_plate() as both:
        yield both


@pytest.mark.mpi
def test_it_is_the_energy_with_the_displacements_held(plate_and_balance):
    plate, balance = plate_and_balance
    for height in (0.0, 1e-3, 1e-2):
        bent = plate.flat + plate.lift(height)
        assert balance.energy(bent) == pytest.approx(plate.relaxed_energy(bent), rel=1e-12)
        # any other pressures have less, and balancing forgets them
        other = plate.solid.interpolate(
            lambda x: np.stack([0 * x[0]] * 3), lambda x: 1e-6 + 0 * x[0]
        )
        disturbed = bent + other.values
        assert plate.energy(disturbed) < balance.energy(bent)
        assert balance.energy(disturbed) == pytest.approx(balance.energy(bent), rel=1e-12)


@pytest.mark.mpi
def test_its_derivative_is_the_residual_of_the_displacements(plate_and_balance):
    plate, balance = plate_and_balance
    here, step = balance.balance(plate.flat + plate.lift(1e-3)), plate.lift(1e-6)
    slope = (balance.energy(here + step) - balance.energy(here + -step)) / 2
    assert slope == pytest.approx(
        plate.newton.layout.dot(plate.newton.residual(here), step), rel=1e-6
    )


@pytest.mark.mpi
def test_an_incompressible_layer_resists_a_change_of_volume(monkeypatch):
    monkeypatch.setattr(buckled_plate, "MATERIAL", MooneyRivlin(4839.1, 14536.0, 0.0))
    with balanced_plate() as (plate, balance):
        rest = balance.energy(plate.flat)
        assert rest == pytest.approx(plate.energy(plate.flat), rel=1e-12)
        rises = [balance.energy(plate.flat + plate.lift(h)) - rest for h in (0.1, 0.2)]
        assert 0 < rises[0] < rises[1] < np.inf


def test_the_viscosity_falls_while_it_is_easy_and_grows_where_a_step_fails():
    control = ViscosityControl(FlowRule(), k=1.0, last=1.0)
    easy = control.after_success(tangents=1, is_nearly_at_rest=False)
    hard = control.after_success(tangents=3, is_nearly_at_rest=False)
    assert easy.k < hard.k < 1.0
    assert control.after_failure(modes=25).k > control.after_failure(modes=1).k > 1.0
    careful = control.after_failure(modes=1).after_success(tangents=1, is_nearly_at_rest=False)
    assert careful.k > 1.0  # it falls by less than it has grown


def test_a_flow_without_viscosity_that_fails_is_not_tried_again_at_once():
    control = ViscosityControl(FlowRule(), k=1.0, last=1.0)
    without = control.after_success(tangents=3, is_nearly_at_rest=True)
    assert without.k == 0
    again = without.after_failure(modes=0)
    assert again.k == without.last == pytest.approx(1 / 3)
    assert again.after_success(tangents=3, is_nearly_at_rest=True).k > 0
    assert again.after_part(is_nearer=False) == again
