"""A design that the finite-element model checks, and whose search it corrects."""

import math
from dataclasses import replace

import numpy as np
import pytest

import bilayer
from bilayer.designing import targets
from bilayer.designing.report import report_text
from bilayer.designing.targets import Target, cap
from bilayer.designing.task import Check, DesignTask
from bilayer.designing.trust_region import Limits
from bilayer.designing.variables import Variable, Variables


def task_of(evaluations, check):
    """A thickness for a hemisphere, on coarse meshes."""
    sheet = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.013)).with_milestones([1.03])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(targets, "NODES", 150)
        target = Target(cap(0.08 / math.pi), "hemisphere")
    return DesignTask(
        sheet,
        target,
        Variables((Variable("kirigami.thickness", 0.8e-3, 1.3e-3),)),
        least_gap=0.0,
        limits=Limits(evaluations),
        check=check,
    )


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """A design of two evaluations with two checks, the second on a finer mesh; its folder."""
    folder = tmp_path_factory.mktemp("design") / "dome"
    return bilayer.design(task_of(2, Check(2, mesh_size=0.011)), folder), folder


@pytest.fixture(scope="module")
def ended(tmp_path_factory):
    """A design whose search the finite-element model does, from the shell's shape; its folder."""
    folder = tmp_path_factory.mktemp("design") / "dome"
    return bilayer.design(task_of(1, Check(1, evaluations=2)), folder), folder


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


def test_a_search_without_a_check_of_its_end_is_refused():
    with pytest.raises(bilayer.InputError, match=r"check\.runs = 0"):
        Check(0, evaluations=2)
