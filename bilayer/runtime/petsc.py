"""The start of PETSc, which reads no options of the user's environment and of their folders."""

import os
import sys
from contextlib import suppress
from importlib import import_module

from bilayer.runtime.temporary_folder import take_usable_temporary_folder

_USERS_OPTIONS = ("PETSC_OPTIONS", "PETSC_OPTIONS_YAML")
_ARGUMENTS = ("-skip_petscrc", "-no_signal_handler")
"""Neither ~/.petscrc nor .petscrc is read. PETSc's handlers of signals would end the process when
a reader of its output has gone (SIGPIPE)."""


def start_petsc() -> None:
    """Start PETSc and SLEPc if they are installed, on all ranks at once; again it does nothing.

    Their start waits for every rank; later some may have nothing to compute and never get there.
    Options of the user's environment are not read: a result would not tell of them. The setting
    `petsc_options` of a solver is the way to give some.
    """
    if "petsc4py.PETSc" in sys.modules:
        return
    take_usable_temporary_folder()
    hidden = {name: os.environ.pop(name) for name in _USERS_OPTIONS if name in os.environ}
    try:
        with suppress(ImportError):
            import petsc4py

            petsc4py.init(["bilayer", *_ARGUMENTS])
            import_module("slepc4py.SLEPc")
    finally:
        os.environ.update(hidden)
