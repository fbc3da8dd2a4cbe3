"""Ctrl-C keeps the milestones that are done, with every model."""

import pytest

from bilayer import solve
from bilayer.errors import Interrupted
from dshell import HingeSettings, MorleySettings, PaperSettings

QUICK = PaperSettings(total_time=0.002)


@pytest.mark.parametrize("settings", [MorleySettings(), HingeSettings(), QUICK])
def test_an_interruption_keeps_the_milestones_done(coarse_specimen, coarse_mesh, settings):
    def interrupt(fraction, message):
        if fraction > 0.5:
            raise KeyboardInterrupt

    specimen = coarse_specimen.with_milestones([1.01, 1.02, 1.03])
    with pytest.raises(Interrupted) as raised:
        solve(specimen, "dshell", settings, mesh=coarse_mesh, progress=interrupt)
    kept = raised.value.result
    assert kept["converged"].values.tolist() == [1, 1, 0]
    assert kept.attrs["stop_reason"] == "interrupted"


def test_one_before_the_first_milestone_leaves_nothing(coarse_specimen, coarse_mesh):
    def interrupt(fraction, message):
        raise KeyboardInterrupt

    specimen = coarse_specimen.with_milestones([1.01, 1.02])
    with pytest.raises(KeyboardInterrupt) as raised:
        solve(specimen, "dshell", QUICK, mesh=coarse_mesh, progress=interrupt)
    assert not isinstance(raised.value, Interrupted)
