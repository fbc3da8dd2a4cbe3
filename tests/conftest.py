"""Fixtures of several test folders."""

import os
import subprocess
import sys

import pytest

from bilayer.runtime.petsc import start_petsc

start_petsc()  # as the command does, before a test's own imports start it with handlers of signals


@pytest.fixture
def bilayer_command(tmp_path):
    """Run the command line as a user does, in an empty folder; return the finished process."""

    def run(*words, **options):
        command = [sys.executable, "-m", "bilayer", *map(str, words)]
        return subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, timeout=600, **options
        )

    return run


@pytest.fixture
def bilayer_on_ranks(tmp_path):
    """Run the command line on ranks of mpirun, in an empty folder; it has to succeed."""

    def run(ranks, *words):
        launched = ("OMPI_COMM", "PMIX", "PRTE")  # by an mpirun that these tests run under
        clean = {k: v for k, v in os.environ.items() if not k.startswith(launched)}
        command = [sys.executable, "-m", "bilayer", *map(str, words)]
        launcher = ["mpirun", "--oversubscribe", "-n", str(ranks)]
        subprocess.run([*launcher, *command], cwd=tmp_path, env=clean, timeout=300, check=True)

    return run
