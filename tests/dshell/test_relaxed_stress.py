"""A layer that relaxes: the energy of a step, relaxation and creep against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from verification.relaxing_layer import (
    LAWS,
    LINEAR,
    SERIES,
    STRAINS,
    bent,
    creep,
    exact_creep,
    held,
    held_error,
    layer_of,
)

from dshell.energies.through_thickness import Laminate


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_strain_that_is_held_relaxes_as_the_series_says(law):
    """Whatever the steps: forces and moments over the first ones are g(t)."""
    assert held_error(law) < 1e-6


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_hold_before_bonding_relaxes_the_prestress(law):
    layer = layer_of(law)
    now = bent(layer, held(layer, STRAINS, hold=5.0), 0.0, STRAINS)
    elastic = Laminate([layer], 1.0).at(STRAINS)
    left = SERIES.stress_left(5.0)
    assert now.resultants() == pytest.approx(left * elastic.resultants(), rel=1e-9, abs=1e-12)


def test_a_hold_does_not_relax_the_stiffness():
    """Of the linear law, in which stress and stiffness have nothing to do with each other."""
    layer = layer_of(LINEAR)
    memory = held(layer, STRAINS, hold=5.0).memory(0.0)
    held_stiffness = Laminate([replace(layer, memory=memory)], 0.0).at(STRAINS).stiffness()
    plain = Laminate([layer], 0.0).at(STRAINS).stiffness()
    assert held_stiffness == pytest.approx(plain, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_energy_of_a_step_has_its_forces_and_stiffness_as_derivatives(law):
    layer = layer_of(law)
    history = held(layer, STRAINS, hold=2.0)
    s = STRAINS + np.array([0.01, 0.02, -0.01, 10.0, 5.0, 3.0])[:, None]
    at = bent(layer, history, 1.5, s)
    for k, size in enumerate([1e-5] * 3 + [1e-2] * 3):
        change = np.zeros_like(s)
        change[k] = size
        up, down = (bent(layer, history, 1.5, s + sign * change) for sign in (1, -1))
        slope = (up.energy() - down.energy()) / (2 * size)
        assert at.resultants()[k] == pytest.approx(slope, rel=1e-6, abs=1e-7)
        bend = (up.resultants() - down.resultants()) / (2 * size)
        assert at.stiffness()[:, k] == pytest.approx(bend, rel=1e-5, abs=1e-5)


def test_creep_of_two_layers_is_that_of_the_closed_form():
    times, found, *given = creep(4000)
    exact = exact_creep(times, *given)
    assert np.abs(found / exact - 1).max() < 1e-6


def test_the_error_of_a_step_is_of_the_second_order():
    errors = []
    for steps in (10, 20):
        times, found, *given = creep(steps)
        errors.append(np.abs(found - exact_creep(times, *given)).max())
    assert 3.5 < errors[0] / errors[1] < 4.5
