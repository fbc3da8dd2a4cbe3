"""A layer of the shell that relaxes: one strain that is held, two layers that creep. SI units."""

from dataclasses import replace

import numpy as np

from bilayer import LinearElastic
from bilayer.mechanics.memory import History
from bilayer.specimen.relaxation import PronySeries
from dshell.energies.through_thickness import Laminate, ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from dshell.materials.remembering import nothing
from verification.laws import LAW_CASES

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
STEPS = (0.0, 0.1, 0.5, 7.0, 30.0, 300.0)


def held_error(law) -> float:
    """Largest error of forces and moments over the first ones against g(t), over the largest."""
    layer = layer_of(law)
    history, time, worst = held(layer, STRAINS), 0.0, 0.0
    first = Laminate([layer], 1.0).at(STRAINS).resultants()
    scale = np.abs(first).max(axis=1, keepdims=True)
    for step in STEPS:
        now = bent(layer, history, step, STRAINS).resultants()
        time += step
        worst = max(worst, float(np.abs((now - SERIES.stress_left(time) * first) / scale).max()))
        history = history.after(step, plain_stress(layer, STRAINS))
    return worst


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
