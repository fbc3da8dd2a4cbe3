"""A design that the finite-element model checks, and whose search it corrects."""

import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from designing_by_elements import task_ended_by_elements, task_of

import bilayer
from bilayer.designing.checked import checked_from
from bilayer.designing.lowest import look_for_lowest
from bilayer.designing.report import report_text
from bilayer.designing.task import Check
from bilayer.solvers.rerun import result_settings


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A design of two evaluations with two checks, the second on a finer mesh; its folder."""
    folder = tmp_path_factory.mktemp("design") / "dome"
    return bilayer.design(task_of(2, Check(2, mesh_size=0.011)), folder), folder


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A design whose search the finite-element model does, from the shell's shape; its folder."""
    folder = tmp_path_factory.mktemp("design") / "dome"
    return bilayer.design(task_ended_by_elements(), folder), folder


def test_both_checks_are_there_and_the_last_one_is_of_the_design(checked):
    outcome, folder = checked
    assert len(outcome.checks) == 2
    assert outcome.check_failure == ""
    last = bilayer.open_result(folder / "check-2.nc")
    assert outcome.checks[-1].quality == float(last["quality"].values[-1])
    held = bilayer.result_specimen(last).layer("kirigami").thickness
    assert held == outcome.specimen.layer("kirigami").thickness
    assert len(outcome.checks[1].mesh.triangles) > len(outcome.checks[0].mesh.triangles)


def test_the_corrected_search_begins_with_the_shape_of_the_finite_elements(checked):
    """At the design that was checked, the shell's shape and its correction are that shape."""
    outcome, _ = checked
    corrected = next(k for k, tried in enumerate(outcome.history) if tried.stage == 3)
    found, true = outcome.history[corrected].distances[0], outcome.checks[0].distance.rms
    shell = outcome.history[corrected - 1].distances[0]
    assert found == pytest.approx(true, rel=1e-5)
    assert abs(shell - true) > 1e-4 * true


def test_a_finished_design_reads_its_checks(checked, monkeypatch):
    outcome, folder = checked
    monkeypatch.setattr("fenics_model.solver.SOLVER", None)
    again = bilayer.design(outcome.task, folder)
    assert [check.distance.rms for check in again.checks] == pytest.approx(
        [check.distance.rms for check in outcome.checks]
    )
    assert np.array_equal(again.from_flat.point, outcome.from_flat.point)


def test_the_report_says_what_the_finite_elements_reach(checked):
    outcome, _ = checked
    text = report_text(outcome, [])
    assert f"by the finite-element model: {1e3 * outcome.checks[-1].distance.rms:.4g} mm" in text
    assert "finite elements, run 2" in text


def test_the_finite_elements_search_themselves(ended):
    outcome, _ = ended
    first, second = (tried for tried in outcome.history if tried.solver == "fenics")
    assert second.best < first.best
    assert (outcome.solves, outcome.solves_by_elements) == (3, 3)
    assert outcome.is_by_elements
    assert outcome.along_the_way.shapes[0].distance == second.best


def test_their_shape_is_found_again_from_the_flat_sheet(ended):
    """On another mesh: that of the search was moved."""
    outcome, _ = ended
    (check,) = outcome.checks
    assert check.distance.rms == pytest.approx(outcome.along_the_way.shapes[0].distance, rel=0.02)
    assert outcome.is_the_same_from_flat


def test_a_search_by_finite_elements_that_is_finished_is_read(ended, monkeypatch):
    outcome, folder = ended
    monkeypatch.setattr("fenics_model.solver.SOLVER", None)
    again = bilayer.design(outcome.task, folder)
    assert [tried.best for tried in again.history] == [tried.best for tried in outcome.history]
    assert np.array_equal(again.along_the_way.point, outcome.along_the_way.point)


def killed_after(seconds, file, folder):
    """Begin the design, or go on with it, and kill it some time after a file is there."""
    script = Path(__file__).with_name("killed_design_by_elements.py")
    with subprocess.Popen([sys.executable, str(script), str(folder)]) as process:
        while not (folder / file).exists() and process.poll() is None:
            time.sleep(0.01)
        time.sleep(seconds)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, f"finished before it was killed, at {file}"


def test_a_search_by_finite_elements_that_is_killed_comes_to_the_same_end(ended, tmp_path):
    """Killed within its evaluations and within the last check, then run to the end."""
    outcome, _ = ended
    folder = tmp_path / "d"
    killed_after(0.2, "stage-3/0001.npz", folder)
    assert not (folder / "stage-3" / "0002.npz").exists()
    killed_after(0.2, "stage-3/0002.npz", folder)
    assert not (folder / "check-1.nc").exists()
    again = bilayer.design(task_ended_by_elements(), folder)
    assert [tried.best for tried in again.history] == [tried.best for tried in outcome.history]
    assert np.array_equal(again.along_the_way.point, outcome.along_the_way.point)
    assert again.checks[-1].distance.rms == outcome.checks[-1].distance.rms


def test_a_search_without_a_check_of_its_end_is_refused():
    with pytest.raises(bilayer.InputError, match=r"check\.runs = 0"):
        Check(0, evaluations=2)


@pytest.fixture(scope="module")
def looked_for(ended, tmp_path_factory):
    """The design of before, checked with contact and as the lowest state."""
    task = task_ended_by_elements()
    folder = tmp_path_factory.mktemp("design") / "dome"
    shutil.copytree(ended[1], folder)
    (folder / "check-1.nc").unlink()
    task = replace(task, check=replace(task.check, contact="barrier", starts=2))
    return bilayer.design(task, folder), folder


def test_a_check_has_contact_and_looks_for_lower_states(looked_for):
    outcome, folder = looked_for
    settings = result_settings(bilayer.open_result(folder / "check-1.nc"))
    assert settings.contact == "barrier"
    assert outcome.lowest.is_checked_shape
    assert "and this is the lowest" in report_text(outcome, [])


def test_a_lower_state_than_the_checked_one_is_told(looked_for, tmp_path):
    """Four strips have two states; the higher one, by the shell, takes the place of the check."""
    outcome, _ = looked_for
    petals = replace(bilayer.paper_specimen().layer("kirigami").pattern, strips=4)
    sheet = bilayer.paper_specimen().with_layer("kirigami", pattern=petals)
    sheet = replace(sheet, mesh=bilayer.MeshSize(0.013)).with_milestones([1.06])
    higher = bilayer.states(sheet, starts=4).isel(prestretch=[1])
    file = tmp_path / "check-1.nc"
    bilayer.write_result(higher, file)
    task = replace(outcome.task, check=Check(1, starts=4))
    found = look_for_lowest(task, checked_from(task, higher, file), tmp_path)
    assert -0.01 < found.below < -0.001
    assert found.lowest.distance.rms > 0
    assert (found.below_by_elements < 0) is not found.is_checked_shape
    lower = replace(found, below_by_elements=-0.004)
    text = report_text(replace(outcome, lowest=lower), [])
    assert "a shape of 0.40% less energy" in text
    same = replace(found, below=float("nan"), below_by_elements=-1e-9)
    assert same.is_checked_shape
    assert same.words.endswith("comes to the checked shape.")
    assert f"the lower state is {1e3 * found.lowest.distance.rms:.4g} mm from the target" in text
