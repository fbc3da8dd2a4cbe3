"""A study's folder with damaged files: each is named, set aside and computed anew."""

import json
import os
import shutil
import signal
import subprocess
import sys

import netCDF4
import numpy as np
import pytest
from studies_for_tests import QUICK, log_lines, write_study

from bilayer import InputError, open_result, open_study, solve
from bilayer.cli.main import main
from bilayer.errors import Interrupted
from bilayer.study.damage import set_aside, set_aside_plan
from bilayer.study.folder import StudyFolder
from bilayer.study.index import read_index
from bilayer.study.plan import read_study
from bilayer.study.records import failure_from, plan_from

MORLEY = """
specimen = "specimen.toml"
solver = "dshell"
[vary]
"prestretch.milestones" = [1.01, 1.02]
"""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A study of one case that is computed: its words, its folder, the case."""
    folder = tmp_path_factory.mktemp("study")
    words = ["study", str(write_study(folder, QUICK)), "-o", str(folder / "out"), "--quiet"]
    assert main(words) == 0
    (case,) = read_study(words[1]).cases
    return words, StudyFolder(folder / "out"), case


def changed(change):
    """Return a damage: a NetCDF file with something changed."""

    def damage(path):
        with netCDF4.Dataset(path, "a") as stored:
            change(stored)

    return damage


def replaced(make):
    """Return a damage: something else in the place of the file."""

    def damage(path):
        path.unlink(missing_ok=True)
        make(path)

    return damage


def flipped(path):
    data = bytearray(path.read_bytes())
    for place in range(96, len(data), 37):
        data[place] ^= 255
    path.write_bytes(data)


def half_of_the_milestones(path):
    result = open_result(path).isel(prestretch=[0])
    path.unlink()
    result.to_netcdf(path)


NO_FILES = {
    "a folder": replaced(lambda path: path.mkdir()),
    "a pipe": replaced(os.mkfifo),
    "a link to itself": replaced(lambda path: path.symlink_to(path)),
}
RESULTS = {
    "empty": lambda path: path.write_bytes(b""),
    "text": lambda path: path.write_text("no result"),
    "cut off": lambda path: path.write_bytes(path.read_bytes()[:3000]),
    "flipped": flipped,
    "without stop_reason": changed(lambda stored: stored.delncattr("stop_reason")),
    "stop_reason a number": changed(lambda stored: stored.setncattr("stop_reason", 3)),
    "of no case": changed(lambda stored: stored.delncattr("study_case")),
    "of another case": changed(lambda stored: stored.setncattr("study_case", "0" * 16)),
    "without position": changed(lambda stored: stored.renameVariable("position", "place")),
    "odd face_nodes": changed(lambda stored: stored.renameDimension("corner", "edge")),
    "odd numbers": changed(lambda stored: stored["converged"].__setitem__(0, 9)),
    "fewer milestones": half_of_the_milestones,
    **NO_FILES,
}
RECORDS = {
    "empty": lambda path: path.write_text(""),
    "a list": lambda path: path.write_text("[]"),
    "no reason": lambda path: path.write_text("{}"),
    "an odd status": lambda path: path.write_text('{"status": "x", "reason": "y"}'),
    "a number as reason": lambda path: path.write_text('{"status": "failed", "reason": 3}'),
    "deep": lambda path: path.write_text("[" * 100_000),
    "bytes": lambda path: path.write_bytes(b"\xff\xfe\x00"),
    **NO_FILES,
}


def start_again(finished, path, capsys):
    """Start the case again; the damaged file is named and set aside, the result as before."""
    words, folder, case = finished
    kept = set(folder.cases.iterdir())
    assert main([*words, "--case", "1"]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("bilayer: ")
    assert str(path) in line
    assert f"set aside as {path.name}.damaged" in line
    assert len(open_result(folder.result_file(case.identity))["quality"]) == 2
    aside = set(folder.cases.iterdir()) - kept - {folder.result_file(case.identity)}
    assert [name.name.partition(".damaged")[0] for name in aside] == [path.name]
    assert main([*words, "--case", "1"]) == 0
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("name", RESULTS)
def test_a_damaged_result_is_computed_anew(finished, name, capsys):
    _, folder, case = finished
    path = folder.result_file(case.identity)
    RESULTS[name](path)
    start_again(finished, path, capsys)


@pytest.mark.parametrize("name", RECORDS)
def test_a_damaged_record_of_a_failure_says_nothing(finished, name, capsys):
    _, folder, case = finished
    folder.result_file(case.identity).unlink()
    RECORDS[name](folder.failure_file(case.identity))
    index = read_index(folder)
    assert set(index["status"]) == {"failed"}
    assert str(folder.failure_file(case.identity)) in index["reason"][0]
    start_again(finished, folder.failure_file(case.identity), capsys)


def no_state(stored):
    stored["resume"].renameVariable("state", "other")


def odd_state(stored):
    stored["resume"].renameVariable("state", "long")
    stored["resume"].createDimension("few", 3)
    stored["resume"].createVariable("state", "f8", ("few",))[:] = 0.0


def no_number(stored):
    stored["resume"]["state"][0] = np.nan


UNFINISHED = {
    "text": RESULTS["text"],
    "a folder": NO_FILES["a folder"],
    "too many": changed(lambda stored: stored["resume"].setncattr("tried", 7)),
    "no state": changed(no_state),
    "an odd state": changed(odd_state),
    "no number": changed(no_number),
    "another specimen": changed(lambda stored: stored.setncattr(
        "specimen", stored.getncattr("specimen").replace("0.016", "0.017"))),
}  # fmt: skip


@pytest.fixture(scope="module")
def interrupted(tmp_path_factory):
    """A study of one case of two milestones, ended when it had one of them."""
    folder = tmp_path_factory.mktemp("interrupted")
    words = ["study", str(write_study(folder, MORLEY)), "-o", str(folder / "out"), "--quiet"]
    kept, (case,) = StudyFolder(folder / "out"), read_study(words[1]).cases
    kept.make()
    told = []

    def stop(step):
        told.append(step)
        if step.is_at_target:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        solve(case.specimen, "dshell", case.settings, observers=[stop],
              output=kept.unfinished_file(case.identity))  # fmt: skip
    return words, kept, case, kept.unfinished_file(case.identity).read_bytes()


@pytest.mark.parametrize("name", UNFINISHED)
def test_a_damaged_file_of_milestones_is_not_gone_on_from(name, interrupted, capsys):
    words, folder, case, content = interrupted
    path = folder.unfinished_file(case.identity)
    shutil.rmtree(folder.path)
    folder.make()
    path.write_bytes(content)
    UNFINISHED[name](path)
    assert main([*words, "--case", "1"]) == 0
    assert capsys.readouterr().err == ""
    assert path.with_name(f"{path.name}.damaged").exists()
    assert log_lines(folder.path, "set aside") == [case.identity]
    result = open_result(folder.result_file(case.identity))
    assert result["converged"].values.tolist() == [1, 1]
    assert "by an earlier run" not in result.attrs["history"]


def test_a_whole_file_of_milestones_is_gone_on_from(interrupted):
    words, folder, case, content = interrupted
    shutil.rmtree(folder.path)
    folder.make()
    folder.unfinished_file(case.identity).write_bytes(content)
    assert main([*words, "--case", "1"]) == 0
    result = open_result(folder.result_file(case.identity))
    assert "1 milestones by an earlier run" in result.attrs["history"]


PLANS = {
    "not JSON": "x",
    "a list": "[]",
    "no cases": '{"fields": []}',
    "empty": '{"fields": [], "cases": []}',
    "no case": '{"fields": [], "cases": [3]}',
}
CASE = {
    "case": "0123456789abcdef", "solver": "dshell", "model": "morley", "mesh": "1",
    "milestones": [1.03, [1.06, 1.05]], "values": {},
}  # fmt: skip
ODD_CASES = {
    "case": ["../../x", "/etc/passwd", "0123", 3, None, "0123456789ABCDEF"],
    "solver": ["os", 3, None, ["dshell"]],
    "model": [None, 3],
    "milestones": [3, [-1.0], ["1.03"], [[1, 2, 3]], None, [[1.0, float("nan")]]],
    "values": [[], None],
}


@pytest.mark.parametrize("name", PLANS)
def test_a_damaged_plan_is_named_and_written_anew(finished, name, capsys):
    words, folder, _ = finished
    folder.plan_file.write_text(PLANS[name])
    told = []
    with pytest.raises(InputError, match=r"study plan .*plan\.json: "):
        read_index(folder)
    assert main(["plot-study", str(folder.path), "--x", "prestretch", "-o", "x.png"]) == 2
    assert main([*words, "--dry-run"]) == 0
    capsys.readouterr()
    set_aside_plan(folder, told.append)
    assert len(told) == 1
    assert "plan.json: " in told[0]
    assert main([*words, "--case", "1"]) == 0
    assert len(read_index(folder)) == 2


@pytest.mark.parametrize(
    ("key", "value"), [(key, value) for key, values in ODD_CASES.items() for value in values]
)
def test_a_plan_is_checked_entry_by_entry(key, value):
    good = json.dumps({"fields": [], "cases": [CASE]})
    assert plan_from(good)["cases"][0]["milestones"] == [(1.03, 1.03), (1.06, 1.05)]
    with pytest.raises(InputError, match=r"cases\[0\]"):
        plan_from(json.dumps({"fields": [], "cases": [CASE | {key: value}]}))


def test_a_record_of_a_failure_is_one_line():
    assert failure_from('{"reason": "a\\nb"}').reason == "a b"


def test_nothing_that_is_in_the_way_blocks_a_start(finished, capsys):
    """Files of the study that are no files; all at once, in a start on processes."""
    words, folder, case = finished
    for path in folder.own_files:
        replaced(os.mkfifo)(path)
    folder.cases.rename(folder.path / "before")
    folder.cases.write_text("")
    assert main(words) == 0
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 6
    assert all(line.startswith(f"bilayer: study file {folder.path}") for line in told)
    assert main(words) == 0
    assert capsys.readouterr().err == ""
    assert folder.has_result(case.identity)
    assert open_study(folder.path)["converged"].values.tolist() == [[1, 1]]


def test_files_of_one_name_are_set_aside_side_by_side(tmp_path):
    for text in ("one", "two", "three"):
        (tmp_path / "a").write_text(text)
        set_aside(tmp_path / "a", "why")
    kept = {path.name: path.read_text() for path in tmp_path.iterdir()}
    assert kept == {"a.damaged": "one", "a.damaged.2": "two", "a.damaged.3": "three"}


def test_what_a_killed_process_left_is_removed_by_the_next_start(finished):
    """Killed while it wrote the plan, the index, a record, a result, the milestones so far."""
    words, folder, case = finished
    before = {path.name for path in folder.path.iterdir() if ".damaged" not in path.name}
    code = (
        "import os, signal, sys\nfrom bilayer.runtime.output_file import whole_file\n"
        "with whole_file(sys.argv[1], 'file') as partial:\n"
        "    partial.write_text('half')\n    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    for file in (
        folder.plan_file,
        folder.index_file,
        folder.failure_file(case.identity),
        folder.result_file("0" * 16),
        folder.unfinished_file(case.identity),
    ):
        ended = subprocess.run([sys.executable, "-c", code, str(file)], check=False)
        assert ended.returncode == -signal.SIGKILL
    assert len([path for path in folder.path.rglob(".*.*") if path.is_dir()]) == 5
    assert main(words) == 0
    assert [path for path in folder.path.rglob(".*.*") if path.is_dir()] == []
    assert {path.name for path in folder.path.iterdir() if ".damaged" not in path.name} == before


@pytest.mark.parametrize("more", [[], ["--case", "1"]])
def test_a_folder_whose_name_is_too_long_is_refused(finished, more, capsys):
    words, _, _ = finished
    assert main([*words[:2], "-o", "a" * 5000, *more]) == 2
    assert "cannot be made (File name too long)" in capsys.readouterr().err
