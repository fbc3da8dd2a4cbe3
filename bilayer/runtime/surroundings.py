"""The variables of the user's environment that have no say in what the command line does.

Each would change numbers that a result does not tell of, or end a library that reads it in a trace.
What is removed here is hidden from all libraries and from the processes that this one starts.
"""

import os
import re
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from bilayer.errors import MachineError
from bilayer.runtime.system import most_open_files

IGNORED = (
    "HDF5_DRIVER", "HDF5_DRIVER_CONFIG", "HDF5_PLUGIN_PATH", "HDF5_PLUGIN_PRELOAD",
    "HDF5_VOL_CONNECTOR", "HDF5_DISABLE_VERSION_CHECK",
    "MATPLOTLIBRC", "MPLBACKEND",
    "PETSC_OPTIONS", "PETSC_OPTIONS_YAML",
    "PYTHONINSPECT", "PYTHONWARNINGS",
)  # fmt: skip
IGNORED_BEGINNINGS = ("TQDM_",)
CHECKED = {
    "HDF5_USE_FILE_LOCKING": "TRUE|FALSE|BEST_EFFORT|1|0",
    "OMP_NUM_THREADS": r"[1-9]\d{0,3}(,[1-9]\d{0,3})*",
    "OPENBLAS_NUM_THREADS": r"[1-9]\d{0,3}",
    "COLUMNS": r"[1-9]\d{1,3}",
}
"""Variables that are kept if they hold what they may hold."""


OPEN_FILES = 64
"""How many files a verb may need open at once: shared libraries that are being loaded, pipes of MPI
and of child processes, inputs, outputs. 18 are enough for a shell on one rank."""


def keep_surroundings_out() -> None:
    """Remove from the environment of this process what must not have a say, and odd values."""
    warned_by_variable = bool(os.environ.get("PYTHONWARNINGS"))
    for name in list(os.environ):
        if name in IGNORED or name.startswith(IGNORED_BEGINNINGS):
            del os.environ[name]
    for name, pattern in CHECKED.items():
        if name in os.environ and not re.fullmatch(pattern, os.environ[name]):
            del os.environ[name]
    _name_home_folder()
    _silence_libraries(warned_by_variable)


def _name_home_folder() -> None:
    """Say where the home folder is if nothing does: Open MPI prints that it misses it."""
    if "HOME" not in os.environ:
        try:
            os.environ["HOME"] = str(Path.home())  # as the system's list of users has it
        except RuntimeError:  # a user of no name, as in a container
            os.environ["HOME"] = os.sep


@contextmanager
def variables_changed(changes: Mapping[str, str | None]) -> Iterator[None]:
    """Change variables of the environment of this process within a block.

    Parameters
    ----------
    changes : mapping of str to str or None
        Name to value; None removes it.
    """
    usual = {name: os.environ.get(name) for name in changes}
    _change(changes)
    try:
        yield
    finally:
        _change(usual)


def _change(variables: Mapping[str, str | None]) -> None:
    for name, value in variables.items():
        os.environ.pop(name, None)
        if value is not None:
            os.environ[name] = value


def _silence_libraries(asked_by_variable: bool) -> None:
    """Let libraries warn nobody: their warnings are for those who write programs.

    `python -W` still says which ones are shown.
    """
    if asked_by_variable:
        sys.warnoptions.clear()  # handed on to other processes
        warnings.resetwarnings()
    if not sys.warnoptions:
        warnings.simplefilter("ignore")


def need_open_files() -> None:
    """Refuse to begin where too few files may be open: MPI and gmsh say so in lines of their own.

    Raises
    ------
    MachineError
        If the limit of open files is below `OPEN_FILES`.
    """
    most = most_open_files()
    if most < OPEN_FILES:
        raise MachineError(
            f"only {most} files may be open at once here, {OPEN_FILES} are needed: "
            f"ulimit -n {OPEN_FILES}"
        )
