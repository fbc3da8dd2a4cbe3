"""A compiler that does not work is a fault of the machine, told in one line."""

import os
import subprocess
import sys

import pytest

from bilayer.errors import MachineError
from fenics_model.api import jit

SOLVE = [
    sys.executable, "-P", "-m", "bilayer", "--quiet", "solve", "paper.toml", "--solver", "fenics",
    "--mesh-size", "0.01", "-o", "result.nc",
]  # fmt: skip


def run_solve(tmp_path, **variables):
    init = [*SOLVE[:4], "init"]
    text = subprocess.run(init, capture_output=True, text=True, check=True).stdout
    (tmp_path / "paper.toml").write_text(text)
    return subprocess.run(
        SOLVE, cwd=tmp_path, env={**os.environ, **variables}, capture_output=True, text=True,
        timeout=120,
    )  # fmt: skip


def test_python_without_docstrings_is_told(tmp_path):
    ended = run_solve(tmp_path, PYTHONOPTIMIZE="2")
    assert ended.returncode == 1
    assert "PYTHONOPTIMIZE" in ended.stderr and ended.stderr.count("\n") == 1


def test_compiler_that_fails_is_told(tmp_path):
    ended = run_solve(tmp_path, CC="/bin/false", XDG_CACHE_HOME=str(tmp_path))
    assert ended.returncode == 1
    assert "/bin/false" in ended.stderr and ended.stderr.count("\n") == 1


def test_other_ranks_tell_of_the_compiler_too():
    def compiler(*_what, **_options):
        raise RuntimeError("Failed just-in-time compilation of form")

    with pytest.raises(MachineError, match="cannot be compiled"):
        jit._compile(compiler)


def test_errors_of_a_form_stay_what_they_are():
    def compiler(*_what, **_options):
        raise ValueError("Invalid shape")

    with pytest.raises(ValueError, match="Invalid shape"):
        jit._compile(compiler)
