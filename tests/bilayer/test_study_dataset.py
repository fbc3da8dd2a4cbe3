"""A study read as one dataset and drawn: its fields as dimensions, what cannot be taken marked."""

import functools
import json
import re
import subprocess
import sys

import dask.array
import numpy as np
import pytest
import xarray as xr
from made_results import cap_result
from studies_for_tests import write_study

from bilayer import open_result, open_study
from bilayer.cli.main import main
from bilayer.errors import InputError
from bilayer.study.figure import draw_study, study_table
from bilayer.study.folder import StudyFolder
from bilayer.study.plan import read_study

HEAD = 'specimen = "specimen.toml"\nsolver = "dshell"\n'
GRID = HEAD + '[vary]\n"cut.strips" = [5, 6]\n"cut.cutout_angle" = [0.3, 0.4, 0.5]\n'


@functools.cache
def caps(specimen, model):
    return cap_result(specimen, model=model)


@pytest.fixture
def made_study(tmp_path):
    """Write a folder as a study would, its results spherical caps; return its path."""

    def make(text, *, without=(), change=lambda case, result: result):
        plan = read_study(write_study(tmp_path, text))
        folder = StudyFolder(tmp_path / "out")
        folder.make()
        folder.keep_plan(plan)
        for number, case in enumerate(plan.cases):
            if number not in without:
                result = caps(case.specimen, case.model).copy(deep=True)
                folder.keep_result(case, change(case, result), 1.0)
        return folder.path

    return make


def test_the_fields_of_a_product_are_dimensions(made_study):
    study = open_study(made_study(GRID))
    assert study["quality"].dims == ("cut.strips", "cut.cutout_angle", "prestretch")
    one = study.sel({"cut.strips": 6, "cut.cutout_angle": 0.4})
    stored = open_result(str(one["case_file"].values))
    assert "strips = 6" in stored.attrs["specimen"]
    for name in ("quality", "height", "unstable_modes"):
        np.testing.assert_array_equal(one[name].values, stored[name].values)
    assert study["height"].attrs == stored["height"].attrs
    np.testing.assert_array_equal(one["span"].values, stored["span"].values)
    assert "position" not in study


def test_nothing_is_read_before_it_is_asked_for(made_study):
    path = made_study(GRID)
    study = open_study(path)
    assert isinstance(study["quality"].data, dask.array.Array)
    for file in (path / "cases").iterdir():
        file.unlink()
    with pytest.raises(InputError, match="cannot be read"):
        study["quality"].compute()


def test_without_dask_all_but_opening_a_study_works(made_study):
    words = (
        "import sys; sys.modules['dask'] = None; import bilayer; bilayer.open_study(sys.argv[1])"
    )
    path = str(made_study(HEAD))
    done = subprocess.run([sys.executable, "-c", words, path], capture_output=True, text=True)
    last = done.stderr.splitlines()[-1]
    assert "ComputationError: a study cannot be opened" in last
    assert last.endswith("expected the package dask (pip install dask)")


def test_many_threads_read_at_once(made_study):
    study = open_study(
        made_study(HEAD + '[vary]\n"substrate.thickness" = [0.001, 0.0011, 0.0012]\n')
    )
    one_by_one = study.compute(scheduler="synchronous")
    for _ in range(10):
        xr.testing.assert_identical(study.compute(scheduler="threads", num_workers=8), one_by_one)


def test_a_case_that_is_missing_is_nan(made_study):
    study = open_study(made_study(GRID, without=[1]))
    missing = study["quality"].isnull().all("prestretch")
    assert missing.values.tolist() == [[False, True, False], [False, False, False]]
    assert study["case_file"].values[0, 1] == ""


def test_cases_that_are_no_product_lie_along_case(made_study):
    study = open_study(
        made_study(HEAD + '[zip]\n"cut.strips" = [5, 6]\n"cut.cutout_angle" = [0.3, 0.4]\n')
    )
    assert study["quality"].dims == ("case", "prestretch")
    assert study["cut.cutout_angle"].values.tolist() == [0.3, 0.4]


def test_prestretches_of_all_cases_share_one_axis(made_study):
    text = HEAD + '[zip]\n"cut.strips" = [5, 5, 6]\n"prestretch.milestones" = [1.03, 1.09, 1.06]\n'
    study = open_study(made_study(text))
    assert study["prestretch"].values.tolist() == [1.03, 1.06, 1.09]
    there = study["quality"].notnull().values
    assert there.tolist() == [[True, False, True], [False, True, False]]


def test_shapes_on_one_mesh_are_in_the_dataset(made_study):
    study = open_study(made_study(HEAD + '[vary]\n"substrate.thickness" = [0.001, 0.0011]\n'))
    assert study["position"].dims[-2:] == ("node", "xyz")
    one = study.isel({"substrate.thickness": 1})
    stored = open_result(str(one["case_file"].values))
    np.testing.assert_array_equal(one["position"].values, stored["position"].values)
    np.testing.assert_array_equal(study["face_nodes"].values, stored["face_nodes"].values)


def test_a_dataset_of_a_study_is_written_and_read_by_xarray_alone(made_study, tmp_path):
    study = open_study(made_study(GRID))
    study.to_netcdf(tmp_path / "study.nc")
    with xr.open_dataset(tmp_path / "study.nc") as stored:
        np.testing.assert_array_equal(stored["quality"].values, study["quality"].values)


def test_a_case_that_stopped_has_variables_of_its_own_and_is_read(made_study):
    def stop_second(case, result):
        stopped = case.values["cut.strips"] == 6
        return cap_result(case.specimen, reached=1.05) if stopped else result

    study = open_study(made_study(HEAD + '[vary]\n"cut.strips" = [5, 6]\n', change=stop_second))
    assert study["converged"].values.tolist() == [[1, 1], [1, 0]]


def unsound(case, result):
    """Make one shape unstable, one touch itself, one not reached."""
    if case.values["cut.strips"] == 6:
        return result
    angle = case.values["cut.cutout_angle"]
    if angle == 0.3:
        result["unstable_modes"][0] = 2
    elif angle == 0.4:
        result["self_contact_gap"][0] = 0.0
    else:
        result["converged"][0] = 0
        result["quality"][0] = np.nan
    return result


def test_points_that_cannot_be_taken_are_marked(made_study):
    study = open_study(made_study(GRID, change=unsound))
    figure = draw_study(study, "cut.cutout_angle", "quality", "cut.strips", {"prestretch": 1.03})
    (axes,) = figure.axes
    points = {line.get_label(): line.get_xydata()[:, 0].tolist() for line in axes.lines}
    assert points["strips 5"] == points["strips 6"] == [0.3, 0.4, 0.5]
    assert points["unstable"] == [0.3]
    assert points["touches itself"] == [0.4]
    assert points["not reached"] == [0.5]
    sound = {"prestretch": 1.06}
    (axes,) = draw_study(study, "cut.cutout_angle", "quality", "cut.strips", sound).axes
    assert [line.get_label() for line in axes.lines] == ["strips 5", "strips 6"]


def test_a_prestretch_that_comes_again_is_told_apart(made_study):
    """As pairs with one larger stretch do, and a load path that goes back."""
    study = open_study(made_study(GRID)).assign_coords(
        prestretch=[1.06, 1.06],
        prestretch_x=("prestretch", [1.06, 1.06]),
        prestretch_y=("prestretch", [1.03, 1.06]),
    )
    chosen = {"prestretch_y": 1.03, "cut.strips": 5}
    table = study_table(study, "cut.cutout_angle", "height", None, chosen)
    expected = 1e3 * study["height"].sel({"cut.strips": 5}).isel(prestretch=0).values
    np.testing.assert_array_equal(table["height"], expected)
    with pytest.raises(InputError, match=r"prestretch_y has the values 1.03, 1.06: .* chosen"):
        study_table(study, "cut.cutout_angle", "height", None, {"cut.strips": 5})
    axes = draw_study(study, "cut.cutout_angle", "height", "prestretch_y", {"cut.strips": 5}).axes
    assert len(axes[0].lines) == 2


def test_a_plan_of_an_earlier_version_is_read(made_study):
    path = made_study(HEAD)
    plan = json.loads((path / "plan.json").read_text())
    for entry in plan["cases"]:
        entry["milestones"] = [max(pair) for pair in entry["milestones"]]
    now = open_study(path).load()
    (path / "plan.json").write_text(json.dumps(plan))
    xr.testing.assert_identical(open_study(path).load(), now)


def test_lengths_are_drawn_in_millimetres(made_study):
    study = open_study(made_study(HEAD + '[vary]\n"cut.inner_radius" = [0.008, 0.012]\n'))
    table = study_table(study, "cut.inner_radius", "height", None, {"prestretch": 1.06})
    assert table["cut.inner_radius"].tolist() == [8.0, 12.0]
    expected = 1e3 * study["height"].sel(prestretch=1.06).values
    np.testing.assert_allclose(table["height"], expected)
    (axes,) = draw_study(study, "cut.inner_radius", "height", None, {"prestretch": 1.06}).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("inner radius (mm)", "height (mm)")
    assert axes.get_title() == "λ = 1.06"


def test_values_with_units_are_drawn_as_numbers(made_study):
    study = open_study(made_study(HEAD + '[vary]\n"cut.cutout_angle" = ["5 deg", "20 deg"]\n'))
    table = study_table(study, "cut.cutout_angle", "height", None, {"prestretch": 1.06})
    np.testing.assert_allclose(table["cut.cutout_angle"], np.radians([5, 20]))


def test_the_command_draws_a_study(made_study, tmp_path, capsys):
    path = str(made_study(GRID))
    words = ["plot-study", path, "--x", "cut.cutout_angle", "-o", str(tmp_path / "f.png")]
    assert main([*words, "--hue", "cut.strips", "--prestretch", "1.06"]) == 0
    assert main([*words, "--hue", "prestretch", "--select", "cut.strips=6"]) == 0
    assert (tmp_path / "f.png").exists()
    for more, message in [
        (["--hue", "cut.strips"], "prestretch has the values 1.03, 1.06: expected one of them"),
        (["--hue", "cut.strip"], "--hue cut.strip: not in this study.*did you mean 'cut.strips'"),
        (["--y", "qualty"], "did you mean 'quality'"),
        (["--prestretch", 400 * "9"], "prestretch = 9+.*: expected a finite number"),
        (["--prestretch", "1.07"], "prestretch = 1.07: not in this study, expected one of 1.03"),
        (["--select", "cut.strips"], "expected FIELD=VALUE"),
    ]:
        capsys.readouterr()
        assert main([*words, *more]) == 2
        assert re.search(message, capsys.readouterr().err)


def unlike(case, result):
    result["quality"][0] = 0.1 * case.specimen.layer("kirigami").pattern.strips
    if case.specimen.layer("kirigami").pattern.strips == 6:
        result["unstable_modes"][0] = 2
    return result


def test_a_study_as_a_map_has_a_cell_for_each_pair(made_study):
    study = open_study(made_study(GRID, change=unlike))
    figure = draw_study(
        study, "cut.cutout_angle", "quality", "cut.strips", {"prestretch": 1.03}, kind="map"
    )
    axes, _ = figure.axes
    assert axes.images[0].get_array().tolist() == [[0.5] * 3, pytest.approx([0.6] * 3)]
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["0.3", "0.4", "0.5"]
    assert [tick.get_text() for tick in axes.get_yticklabels()] == ["strips 5", "strips 6"]
    marks = next(line for line in axes.get_lines() if line.get_label() == "unstable")
    assert marks.get_xydata().tolist() == [[0, 1], [1, 1], [2, 1]]
    assert [text.get_text() for text in figure.legends[0].texts] == ["unstable"]


def test_a_study_as_panels_has_one_for_each_line(made_study, tmp_path):
    folder = made_study(GRID, change=unlike)
    study = open_study(folder)
    figure = draw_study(
        study, "cut.cutout_angle", "quality", "cut.strips", {"prestretch": 1.03}, kind="panels"
    )
    five, six = figure.axes
    assert [axes.get_title() for axes in (five, six)] == ["strips 5", "strips 6"]
    assert six.get_lines()[0].get_ydata().tolist() == pytest.approx([0.6] * 3)
    assert five.get_ylim() == six.get_ylim()
    words = ["plot-study", str(folder), "--x", "cut.cutout_angle", "--prestretch", "1.03"]
    picture = str(tmp_path / "p.png")
    assert main([*words, "--hue", "cut.strips", "--as", "panels", "-o", picture]) == 0
    assert main([*words, "--select", "cut.strips=5", "--as", "map", "-o", picture]) == 2
