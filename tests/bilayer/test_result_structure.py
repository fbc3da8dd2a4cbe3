"""Results whose structure, values or bytes are wrong: each is refused in one line that says why."""

import ctypes
import os
import random
import re
import socket
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
import xarray as xr
from made_results import cap_result

from bilayer import InputError, open_result, write_result
from bilayer.cli.main import main
from bilayer.results.conformity import check_result
from bilayer.results.files import ResumePoint, open_resume_point
from bilayer.results.netcdf import read_netcdf_files
from bilayer.study.scalars import read_scalars


@pytest.fixture(scope="module")
def result():
    return cap_result()


@pytest.fixture(scope="module")
def file(result, tmp_path_factory):
    path = tmp_path_factory.mktemp("results") / "good.nc"
    write_result(result, path)
    return path


def told(capsys, words):
    """Return exit status and what is on stderr, of which there is no more than a line."""
    status = main(words)
    error = capsys.readouterr().err
    assert error.count("\n") <= 1, error
    return status, error


def with_values(name, change):
    """Return a change of a dataset: the values of one variable, its dimensions and attributes."""

    def changed(result):
        variable = result[name]
        values = change(variable.values.copy())
        return result.assign({name: (variable.dims, values, variable.attrs)})

    return changed


def put(*place, value):
    def change(values):
        values[place] = value
        return values

    return change


def as_floats_with(*place, value):
    return lambda values: put(*place, value=value)(values.astype(float))


def with_dims(name, dims, values):
    return lambda result: result.drop_vars(name).assign({name: (dims, values)})


def with_attribute(name, value):
    return lambda result: result.assign_attrs({name: value})


NOT_A_RESULT = {
    "text in face_nodes": (
        with_values("face_nodes", lambda v: v.astype(str)),
        "face_nodes: holds values of the type .*, expected whole numbers",
    ),
    "a gap in face_nodes": (
        with_values("face_nodes", as_floats_with(4, 1, value=np.nan)),
        r"face_nodes\[4, 1\] = nan: expected whole numbers",
    ),
    "halves in face_nodes": (
        with_values("face_nodes", as_floats_with(0, 0, value=1.5)),
        r"face_nodes\[0, 0\] = 1.5: expected whole numbers",
    ),
    "a node that is not there": (
        with_values("face_nodes", put(3, 2, value=100_000)), "triangle 3 .* expected nodes from 0"
    ),
    "a negative node": (
        with_values("face_nodes", put(3, 2, value=-1)), "triangle 3 .* expected nodes from 0"
    ),
    "faces of two corners": (
        with_dims("face_nodes", ("face", "pair"), np.zeros((238, 2), dtype=np.int32)),
        r"face_nodes: has the dimensions \(face: 238, pair: 2\), expected \(face, corner: 3\)",
    ),
    "dimensions the other way round": (
        lambda r: r.assign(position=r["position"].transpose("node", "prestretch", "xyz")),
        "position: has the dimensions .* expected .prestretch, node, xyz: 3.",
    ),
    "a dimension too many": (
        lambda r: r.assign(quality=r["quality"].expand_dims("twice", axis=1)),
        "quality: has the dimensions .prestretch: 3, twice: 1., expected .prestretch.",
    ),
    "points in the plane": (
        lambda r: r.isel(xyz=slice(2)), r"has the dimensions \(node: 135, xyz: 2\), .* xyz: 3\)"
    ),
    "nodes that disagree": (
        lambda r: r.assign(
            position=(("prestretch", "more", "xyz"), np.zeros((3, 9, 3)), {})
        ),
        "position: has the dimensions .prestretch: 3, more: 9, xyz: 3.",
    ),
    "no milestone": (lambda r: r.isel(prestretch=slice(0)), "prestretch: has no milestone"),
    "a reached milestone without a shape": (
        with_values("position", put(1, 5, 2, value=np.nan)),
        r"position\[1, 5, 2\] = nan: expected finite numbers, m",
    ),
    "an infinite place": (
        with_values("reference_position", put(0, 0, value=np.inf)),
        r"reference_position\[0, 0\] = inf: expected finite numbers, m",
    ),
    "complex positions": (
        with_values("position", lambda v: v + 1j), "position: holds values .* complex128"
    ),
    "whole numbers of one byte": (
        with_values("quality", lambda v: np.zeros(3, dtype=np.int8)),
        "quality: holds values of the type int8, expected floating-point",
    ),
    "a stretch that is not the larger one": (
        with_values("prestretch_y", put(1, value=1.07)),
        r"prestretch\[1\] = 1.06: expected the larger of prestretch_x and prestretch_y",
    ),
    "two places of a node": (
        with_values("reference_x", put(3, value=0.0123)),
        r"reference_x\[3\] = 0.0123: expected that of reference_position",
    ),
    "no layer where the region has it": (
        with_values("region", lambda v: np.zeros_like(v)),
        r"layers_present\[\d+, 1\] = 1: expected 1 where the region has the layer",
    ),
    "tables as settings": (with_attribute("settings", "[a]\nb = 1"), "settings: a = .* expected a"),
    "truth values": (
        with_values("converged", lambda v: v.astype(bool)), "converged: holds values .* bool"
    ),
    "more than reached": (with_values("converged", put(0, value=7)), "expected 0 or 1"),
    "fewer than no iterations": (
        with_values("iterations", put(0, value=-3)), r"iterations\[0\] = -3: .* at least 0"
    ),
    "a stretch of nothing": (
        with_values("prestretch_x", put(2, value=0.0)),
        r"prestretch_x\[2\] = 0.0: expected numbers greater than 0",
    ),
    "dates": (
        with_values("wall_time", lambda v: np.full(3, np.datetime64("2024-01-01", "ns"))),
        "wall_time: holds values of the type datetime64",
    ),
    "a region without layers": (
        with_values("region", put(0, value=9)), "triangle 0 has region = 9"
    ),
    "numbers as terms": (
        lambda r: r.assign_coords(term=[1.0, 2.0]), "term: holds values .* expected texts"
    ),
    "a unit that is a number": (
        lambda r: r.assign(quality=("prestretch", r["quality"].values, {"units": 3})),
        "quality: units = 3: expected a text",
    ),
    "a number as specimen": (with_attribute("specimen", 3), "specimen = 3: expected a text"),
    "a list as settings": (
        with_attribute("settings", np.array([1, 2])), "settings = .* expected a text"
    ),
    "no TOML as settings": (with_attribute("settings", "a = = b"), "settings: not valid TOML"),
    "another specimen": (with_attribute("specimen", "[specimen]\nname = 'x'"), "missing"),
    "no TOML as specimen": (with_attribute("specimen", "a = = b"), "not a valid TOML file"),
    "a number as stop_reason": (with_attribute("stop_reason", 1.5), "stop_reason = 1.5"),
    "a text as schema_version": (
        with_attribute("schema_version", "one"), "schema_version = one, expected a whole number"
    ),
    "a list as format": (with_attribute("format", np.arange(3)), "format = .* expected 'bilayer"),
    "half a volume": (
        lambda r: r.assign(volume_cells=(("volume_cell", "vertex"), np.zeros((1, 4), int))),
        "the variable 'volume_position' is missing",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", NOT_A_RESULT)
def test_a_dataset_of_another_structure_is_refused(result, name):
    change, message = NOT_A_RESULT[name]
    check_result(result)
    with pytest.raises(InputError, match=message) as raised:
        check_result(change(result))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "name", ["text in face_nodes", "a number as specimen", "more than reached", "half a volume"]
)
@pytest.mark.parametrize("verb", [["info"], ["convert", "-o", "x.vtu"], ["plot", "-o", "x.png"]])
def test_every_verb_says_so_in_a_line(result, name, verb, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    change, message = NOT_A_RESULT[name]
    change(result).to_netcdf("bad.nc", engine="netcdf4")
    status, error = told(capsys, [verb[0], "bad.nc", *verb[1:]])
    assert status == 2
    assert re.search(f"^bilayer: error: result file bad.nc: .*{message}", error)
    assert [path.name for path in tmp_path.iterdir()] == ["bad.nc"]


def test_a_result_without_a_shape_has_none_to_convert(result, tmp_path, capsys):
    nothing = with_values("converged", np.zeros_like)(result)
    write_result(nothing, tmp_path / "r.nc")
    status, error = told(capsys, ["convert", str(tmp_path / "r.nc"), "-o", str(tmp_path / "x.vtu")])
    assert (status, "r.nc: has no milestone that was reached" in error) == (2, True)


def test_a_single_milestone_is_a_result_too(result, tmp_path):
    result.sel(prestretch=1.06).to_netcdf(tmp_path / "one.nc")
    assert open_result(tmp_path / "one.nc")["quality"] == result["quality"].sel(prestretch=1.06)


def test_flipped_bits_end_no_process(file, tmp_path, capsys):
    """Some flips change no more than a number; what is refused is refused in a line."""
    good = file.read_bytes()
    damaged = tmp_path / "damaged.nc"
    chance = random.Random(14)
    statuses = []
    for count in [1, 30, 30, 30] * 10:
        data = bytearray(good)
        for _ in range(count):
            place = chance.randrange(len(data))
            data[place] ^= 1 << chance.randrange(8)
        damaged.write_bytes(data)
        status, error = told(capsys, ["info", str(damaged)])
        assert (status, bool(error)) in ((0, False), (2, True)), error
        statuses.append(status)
    assert statuses.count(2) > 10


def test_a_file_that_crashes_the_library_ends_no_process(file, tmp_path):
    """Others that are read with it are read all the same."""
    other = tmp_path / "other.nc"
    other.write_bytes(file.read_bytes())
    with netCDF4.Dataset(other, "a") as stored:
        stored.setncattr("crash", 1)

    def read(stored):
        if "crash" in stored.ncattrs():
            ctypes.string_at(0)
        return stored.getncattr("solver")

    found = read_netcdf_files([file, other, file], "result file", read)
    assert found[0] == found[2] == "dshell"
    assert re.search(r"other\.nc: cannot be read \(reading it is .* SIGSEGV", str(found[1]))


@pytest.mark.parametrize("length", [0, 7, 40, 96, 2000, -1])
def test_a_file_that_is_cut_off(file, tmp_path, capsys, length):
    cut = tmp_path / "cut.nc"
    cut.write_bytes(file.read_bytes()[:length])
    status, error = told(capsys, ["info", str(cut)])
    assert status == 2
    assert re.search(r"cannot be read \((is empty|is no NetCDF file|is cut off: has \d+ of)", error)


def fifo(path):
    os.mkfifo(path)


def bound_socket(path):
    with socket.socket(socket.AF_UNIX) as made:
        made.bind(str(path))


def loop(path):
    path.symlink_to(path)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (fifo, "is a pipe"),
        (bound_socket, "is a socket"),
        (loop, "Too many levels of symbolic links"),
        (lambda path: path.symlink_to("/dev/zero"), "is a device"),
        (lambda path: path.mkdir(), "is a folder"),
        (lambda path: None, "No such file or directory"),
    ],
)
@pytest.mark.parametrize(
    ("verb", "name"),
    [(["info"], "x.nc"), (["solve", "--solver", "dshell", "-o", "out.nc"], "x.toml"),
     (["study", "-o", "out"], "x.toml")],
)  # fmt: skip
def test_what_is_no_regular_file_is_not_opened(
    make, reason, verb, name, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    make(tmp_path / name)
    status, error = told(capsys, [verb[0], name, *verb[1:]])
    assert status == 2
    assert reason in error


@pytest.mark.parametrize("address", ["http://localhost:1/a.nc", "s3://a/b.nc", "file:///a.nc"])
def test_an_address_is_no_file(address, capsys):
    status, error = told(capsys, ["info", address])
    assert status == 2
    assert "is an address, expected a file of this machine" in error


def test_a_file_without_permission_says_so(file, tmp_path, monkeypatch, capsys):
    usual = os.open

    def refused(path, *options, **more):
        if str(path) == str(file):
            raise PermissionError(13, "Permission denied", path)
        return usual(path, *options, **more)

    monkeypatch.setattr(os, "open", refused)
    status, error = told(capsys, ["info", str(file)])
    assert (status, "Permission denied" in error) == (2, True)


def test_a_name_that_is_not_utf8(file, tmp_path):
    odd = os.fsencode(tmp_path) + b"/r\xe9sultat.nc"
    with open(odd, "wb") as copy:  # noqa: PTH123  # a name of bytes
        copy.write(file.read_bytes())
    xr.testing.assert_identical(open_result(os.fsdecode(odd)), open_result(file))


def test_a_file_system_without_locks(file):
    code = f"import bilayer; bilayer.open_result({str(file)!r})"
    refuse = "import errno, fcntl, os\nlock = open({0!r}, 'rb')\nfcntl.flock(lock, fcntl.LOCK_EX)\n"
    locked = refuse.format(str(file)) + code
    quiet = {k: v for k, v in os.environ.items() if k != "HDF5_USE_FILE_LOCKING"}
    subprocess.run([sys.executable, "-c", locked], check=True, env=quiet)
    asked = quiet | {"HDF5_USE_FILE_LOCKING": "TRUE"}
    ended = subprocess.run(
        [sys.executable, "-c", locked], check=False, env=asked, capture_output=True, text=True
    )
    assert "cannot be locked: Resource temporarily unavailable; HDF5_USE_" in ended.stderr


def test_data_that_no_file_of_this_size_can_hold(tmp_path):
    with netCDF4.Dataset(tmp_path / "large.nc", "w") as large:
        large.createDimension("all", 10**10)
        large.createVariable("x", "f8", ("all",), zlib=True, chunksizes=(1000,))
    with pytest.raises(InputError, match="states 80000000000 bytes of data in a file of"):
        open_result(tmp_path / "large.nc")


def test_a_file_that_names_another_does_not_get_its_content(file, tmp_path):
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "a.nc", "w") as made:
        for name in ("face", "quality"):
            made[name] = h5py.ExternalLink(str(file), name)
    with pytest.raises(InputError, match=r"a\.nc"):
        open_result(tmp_path / "a.nc")


def test_a_resume_point_of_another_structure(result, tmp_path):
    path = tmp_path / "r.nc"
    write_result(result, path, ResumePoint(2, ("why",), {"state": np.zeros(3)}))
    for name, value in (("tried", "two"), ("tried", -1), ("reasons", 4.0)):
        with netCDF4.Dataset(path, "a") as stored:
            kept = stored["resume"].getncattr(name)
            stored["resume"].setncattr(name, value)
        with pytest.raises(InputError, match=rf"r\.nc: resume: {name} = .*expected"):
            open_resume_point(path)
        with netCDF4.Dataset(path, "a") as stored:
            stored["resume"].delncattr(name)
            stored["resume"].setncattr(name, kept)


def test_scalars_are_checked_as_the_whole_is(result, tmp_path):
    for name in ("more than reached", "a number as stop_reason", "fewer than no iterations"):
        change, message = NOT_A_RESULT[name]
        change(result).to_netcdf(tmp_path / "bad.nc", engine="netcdf4")
        with pytest.raises(InputError, match=rf"bad\.nc: .*{message}"):
            read_scalars(tmp_path / "bad.nc")
