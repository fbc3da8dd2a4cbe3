"""Studies that are run, killed, resumed and changed: nothing is lost and nothing is done twice."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from studies_for_tests import QUICK, log_lines, write_study

from bilayer import open_result, open_study, solve
from bilayer.cli.main import main
from bilayer.errors import ComputationError
from bilayer.study.case_table import case_table
from bilayer.study.compute import compute_case
from bilayer.study.folder import StudyFolder
from bilayer.study.index import TIMINGS, read_index, write_index
from bilayer.study.memory import first_at_once, memory_note
from bilayer.study.plan import read_study
from bilayer.study.run import cases_to_compute, run_study
from dshell.release.specimen_path import ShellPath

ROOT = Path(__file__).parents[2]
ONE_TOO_LARGE = QUICK + '[vary]\n"mesh.size" = [0.016, 1e-6]\n'
TWO_ANGLES = QUICK + '[vary]\n"cut.cutout_angle" = [0.3, 0.4]\n'
LONG = QUICK.replace("0.002", "0.04")
"""Cases of half a second or more, to be met in the middle."""


@pytest.fixture
def study(tmp_path):
    """Write a study file; return how the command line is called for it, and the folder."""

    def write(text):
        return ["study", str(write_study(tmp_path, text)), "-o", str(tmp_path / "out"), "--quiet"]

    return write, tmp_path / "out"


def started(words, **options):
    command = [sys.executable, "-m", "bilayer", *words]
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, **options)


def wait_for_log(folder, event, count=1):
    for _ in range(1200):
        if (folder / "study.log").exists() and len(log_lines(folder, event)) >= count:
            return
        time.sleep(0.05)
    raise AssertionError(f"no {event!r} in the log within a minute")


def test_a_second_start_computes_only_what_is_missing(study, capsys):
    write, out = study
    words = write(TWO_ANGLES)
    assert main([*words, "--dry-run"]) == 0
    assert "2 cases to compute; time unknown" in capsys.readouterr().out
    assert not out.exists()
    assert main(words) == 0
    first = pd.read_csv(out / "study.csv")
    assert list(first["status"]) == ["done"] * 4  # two cases of two milestones
    assert len(log_lines(out, "done")) == 2
    assert main(words) == 0
    pd.testing.assert_frame_equal(pd.read_csv(out / "study.csv"), first)
    changed = write(TWO_ANGLES.replace("[0.3, 0.4]", "[0.4, 0.5]"))
    assert main([*changed, "--dry-run"]) == 0
    told = capsys.readouterr().out
    assert re.search("2 cases, 1 cases to compute; time about .* from 2 finished cases", told)
    assert main(changed) == 0
    done = log_lines(out, "done")
    assert len(done) == len(set(done)) == 3
    assert sorted(pd.read_csv(out / "study.csv")["cut.cutout_angle"].unique()) == [0.4, 0.5]


def test_a_result_opens_as_any_other(study):
    write, out = study
    assert main(write(TWO_ANGLES.replace("[0.3, 0.4]", "[0.4]"))) == 0
    (identity,) = log_lines(out, "done")
    result = open_result(out / "cases" / f"{identity}.nc")
    assert "cutout_angle = 0.4" in result.attrs["specimen"]
    assert result.attrs["study_case"] == identity
    index = read_index(StudyFolder(out))
    assert list(index["quality"]) == list(result["quality"].values)


def test_pairs_with_one_larger_stretch_are_milestones_of_one_case(study):
    write, out = study
    pairs = "[1.03, 1.0], [1.02, 1.03], 1.03, 1.01"
    assert main(write(QUICK + f'[vary]\n"prestretch.milestones" = [{pairs}]\n')) == 0
    index = pd.read_csv(out / "study.csv")
    assert index["prestretch_x"].tolist() == [1.01, 1.03, 1.02, 1.03]
    assert index["prestretch_y"].tolist() == [1.01, 1.0, 1.03, 1.03]
    (identity,) = index["case"].unique()
    result = open_result(out / "cases" / f"{identity}.nc")
    opened = open_study(out)
    for name in ("quality", "height", "converged"):
        assert index[name].to_numpy() == pytest.approx(result[name].values)
        assert opened[name].values[0] == pytest.approx(result[name].values)
    assert opened["position"].values[0] == pytest.approx(result["position"].values)
    chosen = opened.isel(prestretch=opened["prestretch_y"].values == 1.0)
    assert chosen["height"].values[0] == pytest.approx(result["height"].values[[1]])


def test_a_load_path_that_goes_back_is_one_case(study):
    write, out = study
    words = write(QUICK)
    specimen = out.parent / "specimen.toml"
    path = specimen.read_text().replace("[1.03, 1.06]", "[1.03, 1.06, 1.03]")
    specimen.write_text(path)
    assert main(words) == 0
    opened = open_study(out)
    assert opened["prestretch"].values.tolist() == [1.03, 1.06, 1.03]
    assert opened["visit"].values.tolist() == [0, 0, 1]
    assert opened["converged"].values.tolist() == [[1, 1, 1]]


def test_a_case_that_fails_is_recorded_and_stops_no_other(study, capsys):
    """The printed shell refuses a true weight."""
    write, out = study
    words = write(QUICK + '[vary]\n"gravity.acceleration" = [9.81, 0.0]\n')
    assert main(words) == 1
    told = capsys.readouterr().err.strip().splitlines()
    assert len(told) == 1
    assert "gravity.acceleration = 9.81) failed: InputError:" in told[0]
    index = pd.read_csv(out / "study.csv")
    assert set(index["status"][index["gravity.acceleration"] == 0.0]) == {"done"}
    assert main(words) == 1
    assert len(log_lines(out, "failed")) == 1
    assert main([*words, "--retry-failed"]) == 1
    assert (len(log_lines(out, "failed")), len(log_lines(out, "done"))) == (2, 1)


def test_a_case_that_lacks_memory_is_named_and_stops_no_other(study, capsys):
    write, out = study
    words = write(ONE_TOO_LARGE)
    too_large = r"mesh.size = 1e-06\) lacks memory: .*: mesh.size = 1e-06 m: about .* GiB"
    assert main([*words, "--dry-run"]) == 0
    told = capsys.readouterr().out.strip().splitlines()
    assert len(told) == 2
    assert told[0].startswith("2 cases, 1 cases to compute;")
    assert re.search(too_large, told[1])
    assert not out.exists()
    for start in (1, 2):  # it is not held against the case: each start looks at the memory anew
        assert main(words) == 1
        told = capsys.readouterr().err.strip().splitlines()
        assert len(told) == 1
        assert re.search(too_large, told[0])
        index = pd.read_csv(out / "study.csv")
        assert index["status"].tolist() == 2 * ["done"] + 2 * ["lacks memory"]
        assert len(log_lines(out, "lacks memory")) == start
    assert len(log_lines(out, "begun")) == 1


def test_a_task_of_a_job_array_looks_at_the_memory_for_its_own_case_alone(study, capsys):
    write, out = study
    words = write(ONE_TOO_LARGE)
    assert main([*words, "--case", "1"]) == 0
    assert len(log_lines(out, "done")) == 1
    assert main([*words, "--case", "2"]) == 1
    assert "lacks memory: " in capsys.readouterr().err


def test_a_case_that_lacked_memory_is_computed_when_there_is_enough(study):
    write, out = study
    plan = read_study(write(TWO_ANGLES)[1])
    (memory, _) = (case.memory for case in plan.cases)
    index = run_study(plan, out, memory=0.9 * memory)
    assert set(index["status"]) == {"lacks memory"}
    assert set(run_study(plan, out, memory=1.1 * memory)["status"]) == {"done"}
    assert {path.suffix for path in (out / "cases").iterdir()} == {".nc"}


def test_no_more_cases_run_at_once_than_the_memory_holds(study):
    write, out = study
    plan = read_study(write(LONG + '[vary]\n"cut.cutout_angle" = [0.3, 0.31, 0.32, 0.33]\n')[1])
    largest = max(case.memory for case in plan.cases)
    notices = []
    run_study(plan, out, jobs=3, memory=1.5 * largest, notice=notices.append)
    (notice,) = notices
    assert notice.startswith("1 instead of 3 cases at a time: ")
    events = [line.split("\t")[1] for line in (out / "study.log").read_text().splitlines()]
    assert events == 4 * ["begun", "done"]
    assert [first_at_once(plan.cases, jobs, 2.5 * largest) for jobs in (1, 2, 3)] == [1, 2, 2]
    assert memory_note(plan.cases, 3, 9 * largest) == ""


def test_a_case_that_diverges_keeps_its_file_and_is_told(study, capsys):
    write, out = study
    hopeless = 'model = "hinge"\nmax_iterations = 1\nsmallest_step = 1.0\n'
    head, _, _ = QUICK.partition("model")
    assert main(write(head + hopeless)) == 1
    assert "stopped early: " in capsys.readouterr().err
    index = pd.read_csv(out / "study.csv")
    assert set(index["status"]) == {"stopped early"}
    assert open_result(out / "cases" / f"{index['case'][0]}.nc").attrs["stop_reason"]


def test_a_process_that_dies_takes_only_its_case(study):
    write, out = study
    words = write(LONG + '[vary]\n"cut.cutout_angle" = [0.3, 0.4]\n')
    running = started([*words, "--jobs", "1"])
    wait_for_log(out, "begun")
    line = (out / "study.log").read_text().split("\t")
    os.kill(int(line[3].removeprefix("process ")), signal.SIGSEGV)
    _, told = running.communicate(timeout=120)
    assert running.returncode == 1
    assert "died: the process that computed it died" in told
    assert log_lines(out, "died") == [line[2]]
    assert len(log_lines(out, "done")) == 1
    assert main(words) == 0, "the machine may have been to blame"
    assert log_lines(out, "begun").count(line[2]) == 2


def test_a_study_that_is_killed_goes_on(study):
    """Its processes end with it; the next start waits for them, and does nothing twice."""
    write, out = study
    words = [*write(LONG + '[vary]\n"cut.cutout_angle" = [0.3, 0.4, 0.5]\n'), "--jobs", "1"]
    running = started(words)
    wait_for_log(out, "begun", count=2)
    os.kill(running.pid, signal.SIGKILL)
    running.communicate(timeout=60)
    with StudyFolder(out).lock_for_study():  # its worker has ended
        first, finished = log_lines(out, "begun"), log_lines(out, "done")
    assert main(words) == 0
    plan = read_study(words[1])
    cases = [case.identity for case in plan.cases]
    done, again = log_lines(out, "done"), log_lines(out, "begun")[len(first) :]
    assert sorted(done) == sorted(cases), "every case is finished, and once"
    assert not set(again) & set(finished), "what was finished is not begun again"
    untouched = [case for case in cases if case not in first]
    interrupted = [case for case in first if case not in finished]
    assert again == untouched + interrupted, "the interrupted case comes last"
    undisturbed = StudyFolder(out.parent / "undisturbed")
    undisturbed.make()
    undisturbed.keep_plan(plan)
    for case in plan.cases:
        compute_case(case, undisturbed)
    write_index(undisturbed)
    left, right = (
        pd.read_csv(folder.index_file).drop(columns=list(TIMINGS))
        for folder in (StudyFolder(out), undisturbed)
    )
    pd.testing.assert_frame_equal(left, right, check_exact=True)


def test_a_full_disk_stops_the_study_with_words_and_the_next_start_goes_on(study):
    write, out = study
    words = write(TWO_ANGLES)
    limited = ["bash", "-c", 'ulimit -f 12; exec "$@"', "-", sys.executable, "-m", "bilayer"]
    done = subprocess.run([*limited, *words], capture_output=True, text=True, timeout=120)
    assert done.returncode == 1
    assert re.search(r"error: result file .*\.nc: cannot be written", done.stderr)
    assert list((out / "cases").iterdir()) == []
    assert log_lines(out, "not written")
    folder = StudyFolder(out)
    assert len(cases_to_compute(read_study(words[1]), folder, retry_failed=False)) == 2
    assert main([*words, "--case", "1"]) == 0


def test_what_a_killed_process_left_half_written_goes(study):
    write, out = study
    words = write(TWO_ANGLES)
    (case, _) = (case.identity for case in read_study(words[1]).cases)
    left = out / "cases" / f".{case}.abcdefgh"
    left.mkdir(parents=True)
    (left / f"{case}.nc").write_bytes(b"half")
    assert main(words) == 0
    assert {path.suffix for path in (out / "cases").iterdir()} == {".nc"}


@pytest.mark.parametrize("solver", ["fenics", "dshell"])
def test_a_rank_without_a_case_holds_up_no_other(study, bilayer_on_ranks, solver):
    """PETSc is started by all ranks at once, also by those that have nothing to compute."""
    pytest.importorskip("dolfinx")
    write, out = study
    words = write(f'specimen = "specimen.toml"\nsolver = "{solver}"\n[vary]\n'
                  '"prestretch.milestones" = [1.001]\n')  # fmt: skip
    bilayer_on_ranks(2, *words)
    assert len(log_lines(out, "done")) == 1


def test_one_rank_of_mpirun_computes_by_itself_and_ends(study, bilayer_on_ranks):
    """Processes that it started would pass for its rank, and MPI wait for them at its end."""
    pytest.importorskip("mpi4py.MPI")
    write, out = study
    words = write('specimen = "specimen.toml"\nsolver = "dshell"\n[vary]\n'
                  '"cut.cutout_angle" = [0.2, 0.3]\n')  # fmt: skip
    bilayer_on_ranks(1, *words)
    assert len(log_lines(out, "done")) == 2


def test_one_folder_is_for_one_study_at_a_time(study, capsys):
    write, out = study
    words = write(TWO_ANGLES)
    folder = StudyFolder(out)
    folder.make()
    with folder.lock_for_study():
        assert main(words) == 1
    assert "another study is running in it" in capsys.readouterr().err


def test_a_task_of_a_job_array_computes_its_case(study, capsys):
    write, out = study
    words = write(TWO_ANGLES)
    assert main([*words, "--case", "2"]) == 0
    assert main([*words, "--case", "2"]) == 0
    plan = read_study(words[1])
    assert log_lines(out, "done") == [plan.cases[1].identity]
    assert main([*words, "--case", "3"]) == 2
    assert "--case = 3: expected a number from 1 to 2" in capsys.readouterr().err
    assert main([*words, "--case", "x"]) == 2


def test_a_folder_without_a_study_is_no_index(tmp_path):
    with pytest.raises(ValueError, match="has no plan"):
        read_index(StudyFolder(tmp_path))


def test_a_log_that_cannot_be_written_is_told(study):
    write, out = study
    plan = read_study(write(TWO_ANGLES)[1])
    folder = StudyFolder(out)
    folder.make()
    folder.log_file.mkdir()
    with pytest.raises(ComputationError, match=r"study log .* cannot be written"):
        folder.log("begun", plan.cases[0])


MILESTONES = (
    '"prestretch.milestones" = [1.01, 1.02, 1.03, 1.04, 1.05, 1.06]\n"mesh.size" = [0.006]\n'
)


def test_a_case_that_is_killed_keeps_its_milestones_and_goes_on(study, capsys):
    write, out = study
    words = write('specimen = "specimen.toml"\nsolver = "dshell"\n[vary]\n' + MILESTONES)
    folder, (case,) = StudyFolder(out), read_study(words[1]).cases
    running = started([*words, "--case", "1"])
    unfinished = folder.unfinished_file(case.identity)
    while not unfinished.exists():
        time.sleep(0.002)
        assert running.poll() is None
    running.kill()
    running.communicate()
    kept = open_result(unfinished)
    count = int(kept["converged"].sum())
    assert 1 <= count < 6
    index = read_index(folder)
    assert list(index["status"]) == ["unfinished"] * 6
    assert list(index["quality"][:count]) == list(kept["quality"].values[:count])
    assert open_study(out)["quality"].notnull().sum() == count
    assert main(words) == 0
    result = open_result(folder.result_file(case.identity))
    assert list(result["wall_time"].values[:count]) == list(kept["wall_time"].values[:count])
    undisturbed = solve(case.specimen, "dshell")
    for name in ("position", "energy", "quality", "iterations"):
        assert result[name].values == pytest.approx(undisturbed[name].values, rel=1e-9, abs=1e-14)
    assert not unfinished.exists()
    assert list(read_index(folder)["status"]) == ["done"] * 6


def test_a_case_that_meets_an_error_keeps_its_milestones(study, monkeypatch):
    write, out = study
    words = write('specimen = "specimen.toml"\nsolver = "dshell"\n[vary]\n' + MILESTONES)
    folder, (case,) = StudyFolder(out), read_study(words[1]).cases
    follow, calls = ShellPath.approach, []

    def approach(path, target):
        calls.append(target)
        if len(calls) == 3:
            raise TypeError("a fault")
        yield from follow(path, target)

    monkeypatch.setattr(ShellPath, "approach", approach)
    assert main([*words, "--case", "1"]) == 1
    assert folder.failure(case.identity)
    assert list(read_index(folder)["converged"]) == [1, 1, 0, 0, 0, 0]
    assert main([*words, "--case", "1", "--retry-failed"]) == 0
    assert calls == [
        *case.specimen.prestretch.milestones[:3],
        *case.specimen.prestretch.milestones[2:],
    ]


def test_a_study_ends_with_a_table_of_its_cases(study, capsys):
    write, _ = study
    words = [word for word in write(TWO_ANGLES) if word != "--quiet"]
    assert main(words) == 0
    table = capsys.readouterr().out.splitlines()
    assert table[0].split()[:4] == ["case", "solver", "cut.cutout_angle", "status"]
    assert [line.split()[3:8] for line in table[1:3]] == [
        ["0.3", "done", "2", "of", "2"], ["0.4", "done", "2", "of", "2"],
    ]  # fmt: skip
    assert table[3] == "2 done"


def test_a_long_table_is_cut(study, monkeypatch):
    write, out = study
    assert main(write(TWO_ANGLES)) == 0
    monkeypatch.setattr("bilayer.study.case_table.MOST_ROWS", 1)
    lines = case_table(read_index(StudyFolder(out))).splitlines()
    assert len(lines) == 3
    assert lines[-1] == "... and 1 more"


@pytest.mark.parametrize(
    ("first", "sizes"), [("longest", [0.01, 0.016]), ("cheapest", [0.016, 0.01])]
)
def test_the_cheapest_cases_begin_if_asked(tmp_path, first, sizes):
    text = QUICK + '[vary]\n"mesh.size" = [0.016, 0.01]\n'
    plan = read_study(write_study(tmp_path, text))
    waiting = cases_to_compute(plan, StudyFolder(tmp_path / "out"), False, first)
    assert [case.specimen.mesh.size for case in waiting] == sizes


def test_what_a_finished_case_left_unfinished_is_removed_by_the_next_start(study):
    write, out = study
    words = write(QUICK)
    assert main(words) == 0
    folder, case = StudyFolder(out), read_study(words[1]).cases[0]
    finished, left = folder.result_file(case.identity), folder.unfinished_file(case.identity)
    shutil.copy(finished, left)  # as if killed before it was removed
    before = finished.stat().st_mtime_ns
    assert main(words) == 0
    assert not left.exists()
    assert finished.stat().st_mtime_ns == before


def test_a_script_without_a_guard_is_told_so(tmp_path):
    file = write_study(tmp_path, QUICK + '[vary]\n"prestretch.milestones" = [1.03]\n')
    call = f"index = bilayer.run_study(bilayer.read_study({str(file)!r}), 'out', jobs=1)\n"
    bare, guarded = tmp_path / "bare.py", tmp_path / "guarded.py"
    bare.write_text("import bilayer\n" + call)
    guarded.write_text(
        "import bilayer\nif __name__ == '__main__':\n    "
        + call
        + "    print(list(index.status))\n"
    )
    failed = run_script(bare)
    assert failed.returncode == 1
    assert "bare.py: run_study is called when the script is imported" in failed.stderr
    assert not (tmp_path / "out").exists()
    assert run_script(guarded).stdout == "['done']\n"


def run_script(file):
    words = [sys.executable, file.name]
    return subprocess.run(
        words,
        cwd=file.parent,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        timeout=120,
    )
