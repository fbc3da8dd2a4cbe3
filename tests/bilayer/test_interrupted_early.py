"""Ctrl-C and SIGTERM in the first second, while modules are loaded: one line, and the status."""

import subprocess
import sys

import pytest

INTERRUPTED_WHILE_LOADING = """
import importlib.abc, signal, sys

class Interrupting(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            signal.raise_signal({number})

signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
sys.meta_path.insert(0, Interrupting())
sys.argv = ["bilayer", "info", "none.nc"]
from bilayer.__main__ import main
sys.exit(main())
"""


@pytest.mark.parametrize("module", ["bilayer.cli.main", "numpy", "xarray"])
@pytest.mark.parametrize(("number", "status"), [(2, 130), (15, 143)])
def test_a_signal_while_modules_are_loaded_is_told_in_a_line(module, number, status):
    script = INTERRUPTED_WHILE_LOADING.format(module=module, number=number)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (status, "", "bilayer: interrupted\n")
