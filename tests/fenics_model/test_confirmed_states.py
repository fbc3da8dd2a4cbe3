"""The finite-element model is started from the states that the shell found."""

from dataclasses import replace

import numpy as np

import bilayer
from bilayer.landscape import confirm as confirming
from bilayer.landscape.confirm import VARIABLES, confirm
from bilayer.landscape.report import states_table


def test_a_state_of_the_shell_is_confirmed_and_one_that_is_none_is_not():
    specimen = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.016))
    found = bilayer.states(specimen.with_milestones([1.03]), starts=1)
    flat = found.copy(deep=True)
    flat["position"] = found["reference_position"].expand_dims(prestretch=1)
    for states, expected in ((found, 1), (flat, 0)):
        confirmed = confirm(states)
        assert set(VARIABLES) <= set(confirmed)
        assert confirmed["confirmed"].values.tolist() == [expected]
        assert confirmed["confirmed_modes"].values.tolist() == [0]
        assert np.isfinite(confirmed["confirmed_energy"]).all()
        assert (confirmed["confirmed_distance"].values < 0.05) == [bool(expected)]
    assert "FE" in states_table(confirmed).splitlines()[0]


def test_each_of_several_states_is_confirmed_at_its_prestretch_once(monkeypatch):
    """A file of states has as many milestones as states, all at the same prestretch."""
    sheet = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.016))
    twice = bilayer.solve(sheet.with_milestones([1.03, 1.03]), "dshell")
    solved = []

    def solve(specimen, *rest, **options):
        solved.append(specimen.milestones)
        return bilayer.solve(specimen, *rest, **options)

    monkeypatch.setattr(confirming, "solve", solve)
    confirmed = confirm(twice)
    assert solved == [((1.03, 1.03),)] * 2
    assert confirmed["confirmed"].values.tolist() == [1, 1]
