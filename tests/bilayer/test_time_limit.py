"""The time limit for a milestone: a run ends there, keeps what it has, and can go on."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from studies_for_tests import write_study

import bilayer
from bilayer import MeshSize, paper_specimen, solve
from bilayer.cli.main import main
from bilayer.errors import InputError
from bilayer.results.files import open_resume_point
from bilayer.runtime import time_limit
from bilayer.runtime.time_limit import TimeIsUpError, check_time, read_duration, time_is_up
from bilayer.solvers.path import follow_path

COARSE = replace(paper_specimen(), mesh=MeshSize(0.016)).with_milestones([1.02, 1.04])


class Clock:
    """A clock that stands until it is put forward."""

    def __init__(self):
        self.now = 0.0

    def monotonic(self):
        return self.now


@pytest.fixture
def clock(monkeypatch):
    clock = Clock()
    monkeypatch.setattr(time_limit, "time", clock)
    return clock


class Place:
    share, effort = 1.0, 0


class Patient:
    """A path that looks at the time before each target."""

    def approach(self, target):
        check_time()
        yield Place()

    def stopped(self):
        return Place()


def test_a_path_ends_at_the_target_for_which_there_is_no_time():
    steps = list(follow_path(Patient(), [1.0, 2.0], limit=60.0))
    assert [step.is_at_target for step in steps] == [True, True]
    (step,) = follow_path(Patient(), [1.0, 2.0], limit=0.0)
    assert isinstance(step.failure, TimeIsUpError)
    assert not time_is_up()


def test_a_limit_within_another_does_not_lengthen_it(clock):
    with time_limit.time_limit(10.0):
        clock.now = 5.0
        with time_limit.time_limit(60.0):
            clock.now = 9.0
            assert not time_is_up()
            clock.now = 10.0
            assert time_is_up()
        with time_limit.time_limit(0.5):
            assert time_is_up()


def test_a_run_without_time_keeps_its_milestones_and_goes_on(clock, tmp_path):
    output = tmp_path / "run.nc"

    def put_forward(step):
        clock.now += 1000.0 if step.is_at_target else 0.0

    first_only = [lambda step: put_forward(step) if step.index == 0 else None]
    result = solve(COARSE, "dshell", observers=first_only, output=output, limit=60.0)
    assert result["converged"].values.all()  # observers do not count

    class Late(Clock):
        """Every look at this clock takes a second, from the second milestone on."""

        def monotonic(self):
            self.now += self.pace
            return self.now

        pace = 0.0

    time_limit.time = late = Late()
    slower = [lambda step: setattr(late, "pace", float(step.is_at_target))]
    stopped = solve(COARSE, "dshell", observers=slower, output=output, limit=5.0)
    assert list(stopped["converged"].values) == [1, 0]
    assert "the time limit for a milestone is over" in stopped.attrs["stop_reason"]
    assert open_resume_point(output).tried == 1
    late.pace = 0.0
    whole = solve(COARSE, "dshell", output=output, resume=output)
    assert whole["converged"].values.all()
    np.testing.assert_array_equal(whole["position"].values, result["position"].values)
    assert open_resume_point(output) is None


def test_a_case_without_time_stops_early_and_goes_on(tmp_path):
    text = 'specimen = "specimen.toml"\nsolver = "dshell"\n'
    study = ["study", str(write_study(tmp_path, text)), "-o", str(tmp_path / "out"), "--quiet"]
    assert main([*study, "--limit", "0.000001s"]) == 1
    assert set(pd.read_csv(tmp_path / "out" / "study.csv")["status"]) == {"stopped early"}
    assert main(study) == 1  # it is not tried again unasked
    assert main([*study, "--retry-failed"]) == 0
    assert len(list((tmp_path / "out" / "cases").iterdir())) == 1


def test_a_run_from_the_command_line_says_where_it_is(tmp_path, capsys):
    (tmp_path / "sheet.toml").write_text(bilayer.specimen_to_toml(COARSE))
    words = ["solve", str(tmp_path / "sheet.toml"), "--solver", "dshell", "-o"]
    assert main([*words, str(tmp_path / "out.nc"), "--limit", "0.000001"]) == 1
    assert "stopped at prestretch 1: the time limit" in capsys.readouterr().err


@pytest.mark.parametrize("word", ["", "five", "-1s", "0", "1d", "nan", "1e3"])
def test_what_is_no_time(word):
    with pytest.raises(InputError, match=r"--limit = .*: expected a time such as 90s"):
        read_duration("--limit", word)
