"""A layer that relaxes: the energy of a step, relaxation and creep against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from verification.laws import LAW_CASES

from bilayer import LinearElastic
from bilayer.mechanics.memory import History
from bilayer.specimen.relaxation import PronySeries
from dshell.energies.through_thickness import Laminate, ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from dshell.materials.remembering import nothing

SERIES = PronySeries(((0.4, 0.7), (0.3, 20.0)))
LAW = plane_stress_law(LAW_CASES["mooney-rivlin"].law)
LINEAR = plane_stress_law(LinearElastic(1e5, 0.3))
LAWS = {
    "incompressible": LAW,
    "compressible": plane_stress_law(LAW_CASES["mooney-rivlin"].compressible(5e-6)),
    "compressible yeoh": plane_stress_law(LAW_CASES["yeoh"].compressible(5e-6)),
    "linear": LINEAR,
}
STRETCH = np.diag([1.2, 1.1])


def layer_of(law=LAW, series=SERIES, stretch=STRETCH):
    return ShellLayer("film", law, -5e-4, 5e-4, stretch, relaxation=series)


def plain_stress(layer, s):
    """The stresses that are remembered, at the Gauss points, (parts, q, k)."""
    (bent,) = Laminate([layer], 1.0).at(s).layers
    return bent.instantaneous(nothing(layer.law))


def held(layer, s, hold=0.0):
    return History.held(layer.relaxation, plain_stress(layer, s), hold)


def bent(layer, history, step, s):
    return Laminate([replace(layer, memory=history.memory(step))], 1.0).at(s)


STRAINS = np.array([[0.02, -0.01, 0.03, 40.0, -20.0, 15.0], [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]]).T


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_strain_that_is_held_relaxes_as_the_series_says(law):
    """Whatever the steps: forces and moments over the first ones are g(t)."""
    layer = layer_of(law)
    history = held(layer, STRAINS)
    first = bent(layer, history, 0.0, STRAINS).resultants()
    assert first == pytest.approx(Laminate([layer], 1.0).at(STRAINS).resultants(), rel=1e-12)
    time = 0.0
    for step in (0.0, 0.1, 0.5, 7.0, 30.0, 300.0):
        now = bent(layer, history, step, STRAINS).resultants()
        time += step
        assert now == pytest.approx(SERIES.stress_left(time) * first, rel=1e-6, abs=1e-12)
        history = history.after(step, plain_stress(layer, STRAINS))


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


def creep(steps, end=40.0):
    """The strain of a film that relaxes on an elastic one of the same law and thickness, in time.

    Both stretched equally in all directions of the plane, flat; the film by 1 + eps at time 0.
    """
    eps, series = 0.05, PronySeries(((0.6, 10.0),))
    film = layer_of(LINEAR, series, (1 + eps) * np.eye(2))
    sheet = layer_of(LINEAR, PronySeries(), np.eye(2))

    def strains(e):
        return np.array([[e, e, 0.0, 0.0, 0.0, 0.0]]).T

    history = held(film, strains(0.0))
    found = []
    times = np.concatenate([[0.0], np.linspace(0.0, end, steps + 1)[1:]])
    before = 0.0
    for time in times:
        memory = history.memory(time - before)
        both = Laminate([replace(film, memory=memory), sheet], 0.0)
        force = [both.at(strains(e)).resultants()[0, 0] for e in (0.0, 1e-3)]
        e = -force[0] * 1e-3 / (force[1] - force[0])  # the force is linear in the strain
        history = history.after(time - before, plain_stress(film, strains(e)))
        before = time
        found.append(e)
    return times, np.array(found), eps, series.terms[0]


def exact_creep(time, eps, term):
    """Of e + g_inf (e + eps) + H = 0 with H' = -H / tau + g e', and e(0) = -eps / 2."""
    share, tau = term
    relaxed = 1 - share
    end = -eps * relaxed / (1 + relaxed)
    rate = (1 + relaxed) / (2 * tau)
    return end + (-eps / 2 - end) * np.exp(-rate * time)


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
