"""Animations: a picture an equilibrium, computed and never blended."""

import shutil

import numpy as np
import pytest
from made_results import cap_result, small_specimen
from PIL import Image

import bilayer
from bilayer.cli.main import main
from bilayer.figures.animation import save_animation
from bilayer.solvers.between import solve_between


@pytest.fixture(scope="module")
def shell():
    return bilayer.solve(small_specimen((1.02, 1.05)), "dshell")


def test_a_gif_has_a_picture_for_each_milestone_and_holds_the_last(tmp_path):
    save_animation(cap_result(reached=1.07), tmp_path / "a.gif", view="front", seconds=3)
    with Image.open(tmp_path / "a.gif") as film:
        pictures = []
        for number in range(film.n_frames):
            film.seek(number)
            pictures.append((np.asarray(film.convert("L"), dtype=float), film.info["duration"]))
    assert len(pictures) == 2  # the milestone that was not reached has none
    assert np.abs(pictures[0][0] - pictures[1][0]).max() > 50
    assert sum(duration for _, duration in pictures) == pytest.approx(3000, abs=60)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_an_mp4_is_written(tmp_path):
    save_animation(cap_result(), tmp_path / "a.mp4", seconds=1)
    assert b"ftyp" in (tmp_path / "a.mp4").read_bytes()[:12]
    assert len(list(tmp_path.iterdir())) == 1


def test_an_mp4_needs_ffmpeg(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(bilayer.ComputationError, match="ffmpeg is not installed"):
        save_animation(cap_result(), tmp_path / "a.mp4")


def test_what_is_between_is_computed(shell):
    dense = solve_between(shell, 2)
    assert dense["prestretch"].values == pytest.approx([1.02, 1.03, 1.04, 1.05])
    assert (dense["residual"].values < 1e-7).all()
    ends = dense.isel(prestretch=[0, 3])
    assert ends["height"].values == pytest.approx(shell["height"].values, rel=1e-5)
    first, last = shell["position"].values
    blend = first + (last - first) / 3
    assert np.abs(dense["position"].values[1] - blend).max() > 1e-5


def test_the_command_line_animates(shell, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    bilayer.write_result(shell, "a.nc")
    assert main(["animate", "a.nc", "-o", "a.gif", "--between", "1", "--quiet"]) == 0
    with Image.open("a.gif") as film:
        assert film.n_frames >= 3
    for words, message in (
        (["-o", "a.avi"], "ending of animation a.avi"),
        (["-o", "b.gif", "--between", "x"], "--between x: expected a number"),
        (["-o", "b.gif", "--view", "up"], "view = 'up'"),
    ):
        assert main(["animate", "a.nc", *words]) == 2
        assert message in capsys.readouterr().err
