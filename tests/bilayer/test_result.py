"""The dataset: its schema, its round trip through NetCDF, and files that must not be trusted."""

import re

import numpy as np
import pytest
import xarray as xr
from made_results import NoSettings, cap_result, small_specimen
from shapes import cap
from sheets import OUTLINES, PATTERNS, trilayer

from bilayer import (
    ComputationError,
    InputError,
    Response,
    generate_mesh,
    open_result,
    result_mesh,
    result_specimen,
    write_result,
)
from bilayer.measures.shape import measure_shape
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.files import ResumePoint, open_resume_point
from bilayer.results.report import provenance

PER_MILESTONE = {
    "quality", "sphere_radius", "sphere_rmse", "hemisphere_distance", "height", "iterations",
    "load_steps", "residual", "unstable_modes", "converged", "wall_time",
}  # fmt: skip


@pytest.fixture(scope="module")
def result():
    return cap_result()


@pytest.fixture(scope="module")
def stopped():
    return cap_result(reached=1.065)


def test_names_and_dimensions_of_the_schema(result):
    assert result["position"].dims == ("prestretch", "node", "xyz")
    assert result["reference_position"].dims == ("node", "xyz")
    assert result["face_nodes"].dims == ("face", "corner")
    assert result["region"].dims == ("face",)
    assert result["span"].dims == ("prestretch", "xyz")
    assert result["energy"].dims == ("prestretch", "term")
    for name in PER_MILESTONE:
        assert result[name].dims == ("prestretch",)
    assert "last_position" not in result


def test_the_layers_of_a_trilayer_are_in_its_file(tmp_path):
    sheet = trilayer(OUTLINES["ellipse"], PATTERNS["sectors"], PATTERNS["cross"])
    mesh = generate_mesh(sheet)
    write_result(cap_result(sheet, mesh=mesh), tmp_path / "r.nc")
    result = open_result(tmp_path / "r.nc")
    assert result_specimen(result) == sheet
    assert result_mesh(result).same_as(mesh)
    assert result.attrs["reference_surface"] == "middle of substrate"
    assert result["sheet_layer"].values.tolist() == ["lower", "substrate", "upper"]
    present = result["layers_present"].sel(sheet_layer="upper").values
    assert np.flatnonzero(present).tolist() == mesh.faces_of("upper").tolist()
    meanings = ["substrate", "lower+substrate", "substrate+upper", "lower+substrate+upper"]
    assert result["region"].attrs["flag_meanings"].split() == meanings
    text = provenance(result)
    assert "ellipse of 60 x 40 mm, lower: 5 strips, cutouts of 0.4 rad" in text
    assert "; upper: a cross of bars 3.3 mm wide" in text
    assert re.search(r"substrate   1.1 mm, .*, bonded thickness natural, in the middle", text)


def test_a_layer_that_is_stretched_in_its_own_way_says_so():
    turned = Response("path", factor=0.5, angle=0.3)
    sheet = trilayer().with_layer("upper", response=turned)
    sheet = sheet.with_layer("lower", response=Response("fixed", (1.2, 1.1)))
    text = provenance(cap_result(sheet))
    assert "stretched 0.5 times as much at 0.3 rad, bonded thickness natural, above" in text
    assert "stretched by 1.2 and 1.1, bonded thickness natural, below" in text


def test_everything_has_a_unit_or_is_a_count_or_a_label(result):
    for name, variable in result.variables.items():
        assert variable.attrs.get("long_name") or "cf_role" in variable.attrs or name in (
            "xyz", "term"
        ), name  # fmt: skip
        if variable.dtype.kind == "f":
            assert "units" in variable.attrs, name


def test_measures_are_those_of_the_shapes(result):
    mesh = result_mesh(result)
    for k in range(3):
        measures = measure_shape(mesh, result["position"].values[k], 0.04)
        assert result["quality"].values[k] == measures.quality
        assert result["sphere_radius"].values[k] == measures.sphere_radius
        assert result["span"].values[k].tolist() == measures.span.tolist()
        assert result["height"].values[k] == measures.span[2]


def test_a_milestone_that_was_not_reached_is_nan_with_its_last_shape(stopped):
    assert stopped["converged"].values.tolist() == [1, 1, 0]
    assert stopped.attrs["stop_reason"] == "no convergence at 1.065"
    for name in ("position", "quality", "span", "hemisphere_distance"):
        assert np.isnan(stopped[name].values[2]).all()
        assert np.isfinite(stopped[name].values[:2]).all()
    expected = cap(result_mesh(stopped).points, 8 * (1 - 1 / 1.065))
    assert stopped["last_position"].values[2] == pytest.approx(expected)
    assert np.isnan(stopped["last_position"].values[:2]).all()
    assert stopped["last_prestretch"].values[2] == 1.065


def test_milestones_that_were_not_begun_are_nan():
    specimen = small_specimen()
    mesh = generate_mesh(specimen)
    made_by = Provenance.found("dshell", "paper", NoSettings(), {})
    result = build_result(specimen, mesh, [], made_by, stop_reason="nothing was tried")
    assert result["converged"].values.tolist() == [0, 0, 0]
    assert np.isnan(result["position"].values).all()


@pytest.mark.parametrize("name", ["result", "stopped"])
def test_a_file_of_a_run_that_is_not_finished_gives_back_both(name, request, tmp_path):
    written = request.getfixturevalue(name)
    saved = {"state": np.linspace(0, 1, 7), "modes": np.array(-1), "start": np.array("flat, ä")}
    point = ResumePoint(2, ("one reason", "another"), saved)
    write_result(written, tmp_path / "result.nc", point)
    xr.testing.assert_identical(open_result(tmp_path / "result.nc"), written)
    read = open_resume_point(tmp_path / "result.nc")
    assert (read.tried, read.reasons) == (2, ("one reason", "another"))
    assert list(read.saved) == list(saved)
    assert all(np.array_equal(read.saved[key], value) for key, value in saved.items())
    write_result(written, tmp_path / "result.nc")
    assert open_resume_point(tmp_path / "result.nc") is None


@pytest.mark.parametrize("name", ["result", "stopped"])
def test_a_file_gives_back_the_same_dataset(name, request, tmp_path):
    written = request.getfixturevalue(name)
    write_result(written, tmp_path / "result.nc")
    read = open_result(tmp_path / "result.nc")
    xr.testing.assert_identical(read, written)
    assert result_specimen(read) == result_specimen(written) == small_specimen()
    assert result_mesh(read).same_as(generate_mesh(small_specimen()))
    assert list(tmp_path.iterdir()) == [tmp_path / "result.nc"]


def test_plain_xarray_opens_it_without_a_warning(result, tmp_path, recwarn):
    write_result(result, tmp_path / "result.nc")
    with xr.open_dataset(tmp_path / "result.nc") as plain:
        assert plain["quality"].sel(prestretch=1.06) == result["quality"].sel(prestretch=1.06)
        assert plain["wall_time"].dtype.kind == "f"
    assert [str(w.message) for w in recwarn] == []


def test_the_mesh_topology_names_variables_that_are_there(result):
    topology = result["midsurface"].attrs
    assert topology["topology_dimension"] == 2
    for name in (*topology["node_coordinates"].split(), topology["face_node_connectivity"]):
        assert name in result.variables
    assert result["position"].attrs["mesh"] == "midsurface"
    assert result["face_nodes"].values.max() == result.sizes["node"] - 1


def test_coordinates_have_no_gaps_and_so_no_fill_value(result, tmp_path):
    write_result(result, tmp_path / "result.nc")
    with xr.open_dataset(tmp_path / "result.nc", decode_cf=False) as raw:
        assert "_FillValue" not in raw["prestretch"].attrs
        assert "_FillValue" in raw["position"].attrs


def test_a_newer_schema_is_refused(result, tmp_path):
    write_result(result.assign_attrs(schema_version=2), tmp_path / "newer.nc")
    with pytest.raises(InputError, match=r"schema_version = 2, .* at most 1: .*newer version"):
        open_result(tmp_path / "newer.nc")


def foreign(path):
    xr.Dataset({"temperature": ("time", [1.0, 2.0])}).to_netcdf(path)


def of_our_name_without_a_schema(path):
    xr.Dataset(attrs={"format": "bilayer-shells result"}).to_netcdf(path)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (foreign, "format = None, expected 'bilayer-shells result'"),
        (of_our_name_without_a_schema, "schema_version = None"),
        (lambda path: path.write_text("not NetCDF at all"), "is no NetCDF file"),
        (lambda path: path.write_bytes(b""), "is empty"),
        (lambda path: path.mkdir(), "is a folder"),
        (lambda path: None, "No such file"),
    ],
)
def test_files_that_are_no_result_are_refused(tmp_path, make, message):
    path = tmp_path / "file.nc"
    make(path)
    with pytest.raises(InputError, match=f"result file .*file.nc.*{message}"):
        open_result(path)


def test_a_truncated_file_is_refused(result, tmp_path):
    path = tmp_path / "result.nc"
    write_result(result, path)
    path.write_bytes(path.read_bytes()[:2000])
    with pytest.raises(InputError, match="is cut off: has 2000 of"):
        open_result(path)


@pytest.mark.parametrize("size", [0, 512, 20_000])
def test_a_full_disk_leaves_the_earlier_file_intact(result, stopped, tmp_path, full_disk, size):
    path = tmp_path / "result.nc"
    write_result(result, path)
    earlier = path.read_bytes()
    assert len(earlier) > 20_000
    with full_disk(size), pytest.raises(ComputationError, match=r"result\.nc: cannot be written"):
        write_result(stopped, path)
    assert path.read_bytes() == earlier
    assert list(tmp_path.iterdir()) == [path]
    xr.testing.assert_identical(open_result(path), result)


def test_a_folder_that_is_not_there(result, tmp_path):
    with pytest.raises(InputError, match=r"the folder .*missing does not exist"):
        write_result(result, tmp_path / "missing" / "result.nc")
    with pytest.raises(InputError, match="is a folder, expected a file name"):
        write_result(result, tmp_path)


@pytest.mark.parametrize("name", ["position", "face_nodes", "converged"])
def test_a_file_without_one_of_its_variables_is_refused(tmp_path, name):
    write_result(cap_result(reached=1.06).drop_vars(name), tmp_path / "a.nc")
    with pytest.raises(InputError, match=f"the variable '{name}' is missing"):
        open_result(tmp_path / "a.nc")


def test_a_file_without_its_specimen_is_refused(tmp_path):
    result = cap_result(reached=1.06)
    del result.attrs["specimen"]
    write_result(result, tmp_path / "a.nc")
    with pytest.raises(InputError, match="the attribute 'specimen' is missing"):
        open_result(tmp_path / "a.nc")


def test_a_name_may_be_as_long_as_the_system_allows_and_no_longer(result, tmp_path):
    longest = tmp_path / f"{'a' * 252}.nc"
    write_result(result, longest)
    assert list(tmp_path.iterdir()) == [longest]
    with pytest.raises(InputError, match="cannot be made"):
        write_result(result, tmp_path / f"{'a' * 253}.nc")
