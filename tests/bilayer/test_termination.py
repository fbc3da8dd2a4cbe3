"""The end of a job's time keeps the milestones that are done."""

import os
import signal
from contextlib import contextmanager

import pytest

from bilayer.cli import solve
from bilayer.cli.main import main
from bilayer.results.files import open_result


@contextmanager
def ended_at_the_second_milestone(title, shown):
    def progress(fraction, message):
        if fraction > 0.5:
            os.kill(os.getpid(), signal.SIGTERM)

    yield progress


@pytest.mark.parametrize("model", ["hinge", "paper"])
def test_sigterm_keeps_the_milestones_done(tmp_path, capsys, monkeypatch, model):
    monkeypatch.chdir(tmp_path)
    assert main(["init"]) == 0
    (tmp_path / "specimen.toml").write_text(capsys.readouterr().out)
    monkeypatch.setattr(solve, "progress_bar", ended_at_the_second_milestone)
    before = signal.getsignal(signal.SIGTERM)
    words = ["--solver", "dshell", "--model", model, "--mesh-size", "0.012", "-o", "shell.nc"]
    stones = ["--prestretch", "1.01", "1.02", "1.03"]
    assert main(["solve", "specimen.toml", *words, *stones]) == 143
    kept = open_result("shell.nc")
    done = kept["converged"].values.sum()
    told = capsys.readouterr().err
    assert told == f"bilayer: interrupted; shell.nc has {done} of 3 milestones\n"
    assert kept.attrs["stop_reason"] == "interrupted"
    assert kept["converged"].values.tolist()[::2] == [1, 0]
    assert signal.getsignal(signal.SIGTERM) is before
