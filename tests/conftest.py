"""What several test folders share."""

import subprocess
import sys

import pytest


@pytest.fixture
def bilayer_command(tmp_path):
    """Run the command line as a user does, in an empty folder; return the finished process."""

    def run(*words, **options):
        command = [sys.executable, "-m", "bilayer", *map(str, words)]
        return subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, timeout=600, **options
        )

    return run
