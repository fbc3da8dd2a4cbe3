"""Folds that pass 180 degrees: the angle goes on, and the energy with it."""

import numpy as np
import pytest

from bilayer.solvers.path import follow_path
from dshell.energies.assembly import Assembly, deform
from dshell.energies.hinges import Hinges
from dshell.energies.whole_turns import continue_turns
from dshell.settings import MorleySettings
from dshell.solve.linear_solver import SuperLUSolver
from dshell.solve.newton import Body, EquilibriumSolver, NewtonLimits
from dshell.solver import open_path

TURN_DOF = 12


def folded(angle, turns=0.0):
    """Return the state of one hinge, the apex of its second triangle turned by an angle."""
    apex = [0.5, -np.cos(angle), -np.sin(angle)]
    corners = np.array([[0, 0, 0], [1, 0, 0], [0.5, 1, 0], apex], dtype=float)
    return np.concatenate([corners.reshape(-1), [turns]])


def hinge(natural_angle):
    nodes = np.array([[0, 1, 2, 3]])
    return Hinges(nodes, np.ones(1), np.full(1, natural_angle), np.array([TURN_DOF]))


@pytest.mark.parametrize("end", [5 * np.pi, -3.5 * np.pi])
def test_the_angle_counts_how_often_the_fold_goes_round(end):
    term, state = hinge(0.0), folded(0.0)
    for angle in np.linspace(0, end, 60):
        before = deform([term], state)
        state = folded(angle, state[TURN_DOF])
        continued = continue_turns(before, deform([term], state), state)
        state = state if continued is None else continued
    assert term.at(state).angles == pytest.approx([end])
    assert term.at(state).energy() == pytest.approx([0.5 * end**2])


def test_a_hinge_comes_to_rest_beyond_180_degrees():
    """With a spring against it, so that the whole step from flat is not the answer."""
    body = Body([hinge(np.radians(250))], np.zeros(TURN_DOF + 1))
    held = np.setdiff1d(np.arange(TURN_DOF + 1), [10, 11])
    solver = EquilibriumSolver(Assembly(TURN_DOF + 1, body.energies, held), SuperLUSolver())
    outcome = solver.find_minimum([body], folded(0.0), NewtonLimits(1e-9, 200, 0.2))
    assert outcome.converged
    assert body.energies[0].at(outcome.state).angles == pytest.approx(np.radians([250]))


def test_a_path_goes_on_from_a_state_saved_without_whole_turns(coarse_specimen, coarse_mesh):
    settings = MorleySettings()
    specimen = coarse_specimen.with_milestones([1.03])
    target = specimen.prestretch.milestones[0]
    path = open_path(specimen, settings, mesh=coarse_mesh)
    saved = [step.point for step in follow_path(path, [target])][-1].save()
    edges = (len(saved["state"]) - 3 * len(coarse_mesh.points)) // 2
    again = open_path(specimen, settings, mesh=coarse_mesh)
    again.restore({**saved, "state": saved["state"][:-edges]})
    (found,) = again.approach(target)
    assert np.array_equal(found.state, saved["state"])
