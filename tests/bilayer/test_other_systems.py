"""macOS and Windows lack some of what Linux has: the shell, a study and the rest do without."""

import ast
import os
import subprocess
import sys
from pathlib import Path

import pytest
from studies_for_tests import QUICK, write_study

from bilayer.runtime import system

ROOT = Path(__file__).parents[2]

PROGRESS = ("dshell: ", "study: ")
"""The beginning of a line about a run that takes long, on a machine that is busy."""

WITHOUT = """
import os, signal, sys
import psutil, gmsh, netCDF4, platformdirs  # others have their own ways on each system

for module in ("fcntl", "resource", "pwd", "grp", "termios", "mpi4py", "petsc4py"):
    sys.modules[module] = None
for name in ("posix_fallocate", "sched_getaffinity", "fork", "forkpty", "getuid", "geteuid",
             "getppid", "mkfifo", "waitid"):
    if hasattr(os, name):
        delattr(os, name)
for name in ("pthread_sigmask", "setitimer", "SIGALRM", "SIGKILL", "SIGHUP", "SIGPIPE"):
    if hasattr(signal, name):
        delattr(signal, name)

if __name__ == "__main__":
    from bilayer.cli.main import main
    sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture
def command(tmp_path):
    """Run the command line where the system lacks all that is hidden."""
    (tmp_path / "without.py").write_text(WITHOUT)

    def run(*words):
        own = os.environ | {"PYTHONPATH": str(ROOT)}
        done = subprocess.run(
            [sys.executable, "without.py", *words],
            cwd=tmp_path, env=own, capture_output=True, text=True, timeout=120,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        assert all(line.startswith(PROGRESS) for line in done.stderr.splitlines()), done.stderr
        return done.stdout

    return run


def test_the_shell_and_a_study_need_nothing_of_linux_alone(command, tmp_path):
    write_study(tmp_path, QUICK + '[vary]\n"cut.strips" = [4, 5]\n')
    solve = ["solve", "specimen.toml", "--solver", "dshell", "--prestretch", "1.03"]
    assert "yes" in command(*solve, "-o", "shell.nc")
    assert "1 of 1 reached" in command("info", "shell.nc")
    command("plot", "shell.nc", "-o", "shell.png")
    command("convert", "shell.nc", "--solid", "-o", "shell.stl")
    command("cut", "specimen.toml", "-o", "parts.dxf")
    assert "2 done" in command("study", "study.toml", "-o", "out", "--jobs", "2")
    assert len(list((tmp_path / "out" / "cases").glob("*.nc"))) == 2
    assert not list((tmp_path / "out" / "cases").glob("*.failed"))


def test_room_is_reserved_without_the_call_for_it(tmp_path, monkeypatch):
    monkeypatch.delattr(os, "posix_fallocate")
    with (tmp_path / "room").open("wb") as file:
        system.reserve_room(file.fileno(), 3 * 2**20 + 5)
    assert (tmp_path / "room").stat().st_size == 3 * 2**20 + 5
    with open("/dev/full", "wb") as full, pytest.raises(OSError, match="No space"):  # noqa: PTH123
        system.reserve_room(full.fileno(), 5)


def test_locks_cores_and_users_without_the_system_for_them(tmp_path, monkeypatch):
    monkeypatch.setattr(system, "fcntl", None)
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.delattr(os, "fork")
    monkeypatch.delattr(os, "getuid")
    with (tmp_path / "lock").open("a") as one, (tmp_path / "lock").open("a") as other:
        assert system.lock_alone(one.fileno())
        assert system.lock_shared(other.fileno())
    assert system.available_cores() == os.cpu_count()
    assert system.process_context().get_start_method() == "spawn"
    assert system.user_number() == 0


def test_a_lock_is_had_by_one_alone_or_by_several_together(tmp_path):
    with (tmp_path / "lock").open("a") as one, (tmp_path / "lock").open("a") as other:
        assert system.lock_shared(one.fileno())
        assert system.lock_shared(other.fileno())
        assert not system.lock_alone(one.fileno())
        other.close()
        assert system.lock_alone(one.fileno())


ONLY_POSIX = {"fcntl", "resource", "pwd", "grp", "termios", "pty"}


@pytest.mark.parametrize("package", ["bilayer", "dshell"])
def test_modules_that_not_every_system_has_are_loaded_where_they_may_be_missing(package):
    """At the top of a module only within `try`; the finite-element model needs Linux or macOS."""
    for file in (ROOT / package).rglob("*.py"):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            assert not ONLY_POSIX & set(names), file
