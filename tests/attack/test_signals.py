"""Ctrl-C and SIGTERM at a few of the moments that `scripts/attack signals` goes through."""

import signal

import pytest

from attack.bench import Bench
from attack.signals import MOMENTS, Runs

CHOSEN = [
    ("shell: loading xarray", signal.SIGTERM),
    ("shell: solving, 4", signal.SIGINT),
    ("study: computing", signal.SIGINT),
    ("study: the index", signal.SIGTERM),
]


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    place = tmp_path_factory.mktemp("signals")
    return Runs(Bench(place / "bench"), place)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "number"), CHOSEN)
def test_a_signal_is_told_in_a_line_and_the_next_start_goes_on(runs, name, number):
    (moment,) = (m for m in MOMENTS if f"{m.run}: {m.what}" == name)
    report = runs.strike(moment, number)
    assert report.wrong == ""
