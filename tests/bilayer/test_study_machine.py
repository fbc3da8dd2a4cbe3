"""What comes from the machine is never held against a case: mended, the study goes on by itself."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
from studies_for_tests import QUICK, log_lines, write_study

from bilayer.cli.main import main
from bilayer.errors import ComputationError, InputError, MachineError
from bilayer.runtime import memory
from bilayer.runtime.machine_faults import is_of_the_machine, lacks_memory
from bilayer.runtime.system import address_space_left
from bilayer.study import compute
from bilayer.study.folder import StudyFolder
from bilayer.study.index import read_index
from bilayer.study.plan import read_study

ROOT = Path(__file__).parents[2]
TWO = QUICK + '[vary]\n"cut.strips" = [4, 5]\n"prestretch.milestones" = [1.03]\n'


@pytest.fixture
def words(tmp_path):
    """Return the words of a study of two quick cases."""
    file = write_study(tmp_path, TWO)
    return ["study", str(file), "-o", str(tmp_path / "out"), "--quiet"]


@pytest.fixture
def case(words):
    """Return a case, and the folder of its study."""
    plan, folder = read_study(words[1]), StudyFolder(words[3])
    folder.make()
    folder.keep_plan(plan)
    return plan.cases[0], folder


def caused(error, cause):
    error.__cause__ = cause
    return error


OF_MEMORY = [
    MemoryError(),
    OSError(errno.ENOMEM, "Cannot allocate memory"),
    RuntimeError("error code 55\n[0] Out of memory. Allocated: 0, Used by process: 123"),
    ImportError("libopenblas.so.0: cannot allocate memory in static TLS block"),
    caused(ComputationError("gmsh could not mesh the specimen"), RuntimeError("std::bad_alloc")),
]
OF_THE_MACHINE = [
    OSError(errno.EIO, "Input/output error", "/usr/lib/libgmsh.so"),
    ImportError("libGLU.so.1: cannot open shared object file"),
    caused(ComputationError("gmsh cannot be loaded"), ImportError("libGLU.so.1")),
    TimeoutError("the lock of a compiled form is held"),
]
OF_THE_CASE = [
    InputError("cut.strips = 0"),
    ComputationError("no convergence"),
    ValueError("a fault"),
]


@pytest.mark.parametrize("error", OF_MEMORY, ids=str)
def test_a_lack_of_memory_is_left_for_the_next_start(case, monkeypatch, error):
    one, folder = case
    monkeypatch.setattr(compute, "solve", raising(error))
    compute.compute_case(one, folder)
    assert set(read_index(folder)["status"]) == {"lacks memory", "missing"}
    assert not folder.has_failed(one.identity)


@pytest.mark.parametrize("error", OF_THE_MACHINE, ids=str)
def test_a_fault_of_the_machine_ends_the_study_and_is_held_against_no_case(
    case, monkeypatch, error
):
    one, folder = case
    monkeypatch.setattr(compute, "solve", raising(error))
    with pytest.raises(MachineError):
        compute.compute_case(one, folder)
    assert set(read_index(folder)["status"]) == {"missing"}


@pytest.mark.parametrize("error", OF_THE_CASE, ids=str)
def test_a_fault_of_a_case_stays_with_it(case, monkeypatch, error):
    one, folder = case
    assert not (lacks_memory(error) or is_of_the_machine(error))
    monkeypatch.setattr(compute, "solve", raising(error))
    compute.compute_case(one, folder)
    assert folder.has_failed(one.identity)


def raising(error):
    def solve(*words, **options):
        raise error

    return solve


def test_a_case_that_stops_for_lack_of_memory_is_computed_again(case, monkeypatch):
    one, folder = case
    usual = compute.solve

    def stopped(*words, **options):
        result = usual(*words, **options)
        result.attrs["stop_reason"] = "stopped at prestretch 1.02: MemoryError: no more"
        return result

    monkeypatch.setattr(compute, "solve", stopped)
    compute.compute_case(one, folder)
    assert not folder.has_result(one.identity)
    monkeypatch.setattr(compute, "solve", usual)
    compute.compute_case(one, folder)
    assert folder.has_result(one.identity)


def run(words, prelude="", **variables):
    """Run the command line as a user does, after some commands of bash."""
    line = f'{prelude} exec "$@"'
    command = ["bash", "-c", line, "-", sys.executable, "-P", "-m", "bilayer", *words]
    own = os.environ | {"PYTHONPATH": str(ROOT)} | variables
    return subprocess.run(command, env=own, capture_output=True, text=True, timeout=120)


def test_a_study_goes_on_when_the_limit_of_its_memory_is_lifted(words):
    limited = run(words, "ulimit -v 600000;", OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
    assert limited.returncode == 1
    assert "Traceback" not in limited.stderr
    assert not log_lines(Path(words[3]), "failed") if Path(words[3], "study.log").exists() else True
    assert main(words) == 0


@pytest.mark.parametrize("folder", ["gone", "long"])
def test_a_study_runs_whatever_the_temporary_folder(words, tmp_path, folder):
    named = tmp_path / ("gone" if folder == "gone" else "/".join(["slurm-job"] * 12))
    if folder == "long":
        named.mkdir(parents=True)
    done = run(words, TMPDIR=str(named))
    assert done.returncode == 0
    assert done.stderr.count("\n") == 1
    assert f"bilayer: TMPDIR = {named}: is" in done.stderr
    assert len(list((tmp_path / "out" / "cases").glob("*.nc"))) == 2


def test_limits_of_the_process_count_as_memory(tmp_path, monkeypatch):
    group = tmp_path / "job" / "step"
    group.mkdir(parents=True)
    monkeypatch.setattr(memory, "OWN_GROUP", tmp_path / "cgroup")
    (tmp_path / "cgroup").write_text("1:name=systemd:/else\n0::/job/step\n")
    assert memory.control_group_left(tmp_path) == float("inf")
    for folder, most in ((group, "max"), (group.parent, 3_000_000)):
        (folder / "memory.max").write_text(f"{most}\n")
        (folder / "memory.current").write_text("2000000\n")
        (folder / "memory.stat").write_text("anon 1\ninactive_file 500000\n")
    assert memory.control_group_left(tmp_path) == 1_500_000
    assert address_space_left(0) > 0
