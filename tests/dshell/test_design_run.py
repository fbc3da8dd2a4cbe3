"""A design from begin to end on a coarse mesh; one that is ended goes on to the same end."""

import math
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designing_task import small_task

import bilayer
from bilayer import ComputationError, InputError, design
from bilayer.cli.main import main
from bilayer.designing import targets
from bilayer.designing.folder import DesignFolder
from bilayer.designing.scenarios import Robustness
from bilayer.designing.trust_region import Limits
from bilayer.errors import NotResumableError
from bilayer.specimen.toml import specimen_to_toml


@pytest.fixture(scope="module", autouse=True)
def coarse_target():
    """Formulas of few nodes, so that the tests are quick."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(targets, "NODES", 150)
        yield


@pytest.fixture(scope="module")
def task(coarse_target):
    return small_task()


@pytest.fixture(scope="module")
def run(task, tmp_path_factory):
    """A finished design and its folder."""
    folder = tmp_path_factory.mktemp("design") / "dome"
    return design(task, folder), folder


def numbers_of(outcome):
    return np.concatenate([outcome.from_flat.point, [outcome.from_flat.value],
                           [tried.best for tried in outcome.history]])  # fmt: skip


def test_the_shape_comes_nearer_to_the_target(run, task):
    outcome, _ = run
    first = outcome.history[0].distances[0]
    assert outcome.from_flat.shapes[0].distance < 0.95 * first
    assert outcome.solves == len(outcome.history)
    assert len(outcome.history) <= task.limits.evaluations
    assert all(0 <= share <= 1 for share in outcome.from_flat.point)


class KilledError(Exception):
    """The end of the process, for the test."""


def test_a_design_that_was_killed_comes_to_the_same_end(run, task, tmp_path):
    after, seen = 2, []

    def kill(tried):
        seen.append(tried)
        if len(seen) == after:
            raise KilledError

    with pytest.raises(KilledError):
        design(task, tmp_path / "d", observer=kill)
    assert np.array_equal(numbers_of(design(task, tmp_path / "d")), numbers_of(run[0]))


def test_a_design_whose_process_is_killed_comes_to_the_same_end(run, task, tmp_path):
    """At three moments of a pseudo-random choice, in the same folder, then to the end."""
    folder, moments = tmp_path / "d", np.random.default_rng(19).uniform(0.1, 1.2, 3)
    for moment in moments:
        killed_after(moment, folder)
    left = [file for file in folder.rglob("*") if file.suffix == ".npz"]
    assert all(np.load(file).files for file in left)  # whole, whenever it was
    assert np.array_equal(numbers_of(design(task, folder)), numbers_of(run[0]))


def killed_after(seconds, folder):
    script = Path(__file__).with_name("killed_design.py")
    with subprocess.Popen(
        [sys.executable, str(script), str(folder)], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout.readline() == "ready\n"
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        assert process.wait() in (-signal.SIGKILL, 0)


def test_a_finished_design_is_not_computed_again(run, task, monkeypatch):
    monkeypatch.setattr(
        "bilayer.designing.evaluation.find_shape", lambda *given: pytest.fail("computed again")
    )
    assert np.array_equal(numbers_of(design(task, run[1])), numbers_of(run[0]))


def test_the_folder_of_another_design_is_refused(run, task):
    with pytest.raises(InputError, match="another design"):
        design(replace(task, least_gap=1e-3), run[1])


def test_two_runs_do_not_share_a_folder(run, task):
    with DesignFolder(run[1]).lock(), pytest.raises(ComputationError, match="another run"):
        design(task, run[1])


def test_a_damaged_file_is_named(run, task, tmp_path):
    folder = tmp_path / "copy"
    shutil.copytree(run[1], folder)
    file = folder / "stage-1" / "0002.npz"
    file.write_bytes(file.read_bytes()[:100])
    with pytest.raises(NotResumableError, match=r"0002\.npz"):
        design(task, folder)


def test_an_impossible_target_says_what_holds_it(task, tmp_path):
    narrow = replace(
        task.variables.variables[0], name="kirigami.thickness", low=1.4e-3, high=1.6e-3
    )
    wanted = replace(
        task, variables=type(task.variables)((narrow,)), limits=Limits(3, 1.0),
        robustness=Robustness(0.05, ("prestretch",)),
    )  # fmt: skip
    outcome = design(wanted, tmp_path / "d")
    assert outcome.solves == 3 * len(outcome.history)
    assert outcome.from_flat.shapes[0].distance > 1e-3
    assert any("kirigami.thickness" in held for held in outcome.bounds_reached)


def test_the_command_leaves_what_is_needed_to_make_it(task, tmp_path, capsys):
    (tmp_path / "sheet.toml").write_text(specimen_to_toml(task.specimen))
    (tmp_path / "d.toml").write_text(
        'specimen = "sheet.toml"\n[target]\nshape = "hemisphere"\n[free]\n'
        '"kirigami.thickness" = ["1 mm", "3 mm"]\n[search]\nevaluations = 3\n'
    )
    assert main(["design", str(tmp_path / "d.toml"), "-o", str(tmp_path / "out")]) == 0
    assert "mm from the target" in capsys.readouterr().out
    folder = tmp_path / "out"
    names = {file.name for file in folder.iterdir()}
    assert {"specimen.toml", "report.md", "shape.png", "search.png", "parts-kirigami.dxf"} <= names
    made = bilayer.read_specimen(folder / "specimen.toml")
    report = (folder / "report.md").read_text()
    thickness = 1e3 * made.layer("kirigami").thickness
    assert f"{thickness:.5g}" in report
    assert "by the shell alone" in report
    assert math.isclose(made.characteristic_length, 0.04)


def test_a_design_file_that_is_wrong_is_bad_input(tmp_path, capsys):
    (tmp_path / "d.toml").write_text("target = 3\n")
    assert main(["design", str(tmp_path / "d.toml"), "-o", str(tmp_path / "out")]) == 2
    assert "specimen" in capsys.readouterr().err
