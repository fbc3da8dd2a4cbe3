"""The user's options for PETSc: in force while they are needed, and checked to be understood."""

import ctypes
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

from petsc4py import PETSc

from bilayer.errors import InputError

_WRONG_OPTION = (56, 60, 62, 63, 83, 86, 92)
"""PETSc's codes: unsupported, unequal, wrong, out of range, unreadable, unknown or absent."""


class UserOptions:
    """Options as text, over those of the global database, over defaults.

    Parameters
    ----------
    text : str
        As on a command line.
    defaults : mapping of str to str
        Values by name, without the prefix.
    prefix : str
        Of every name.

    Raises
    ------
    InputError
        A name does not begin with the prefix.
    """

    def __init__(self, text: str, defaults: Mapping[str, str], prefix: str) -> None:
        self._text, self._prefix = text, prefix
        self._defaults = {prefix + name: value for name, value in defaults.items()}
        own = PETSc.Options().create()
        own.insertString(text)
        self._unused = set(own.getAll())
        own.destroy()
        for name in sorted(self._unused):
            if not name.startswith(prefix):
                raise self._error(f"names that begin with -{prefix}", f"-{name}")

    @contextmanager
    def apply(self) -> Iterator[None]:
        """Put defaults and text into the global database meanwhile.

        Raises
        ------
        InputError
            PETSc complains about a value.
        """
        database = PETSc.Options()
        before = dict(database.getAll())
        for name, value in self._defaults.items():
            if name not in before:
                database.setValue(name, value)
        database.insertString(self._text)
        try:
            yield
        except PETSc.Error as error:
            if error.ierr not in _WRONG_OPTION:
                raise
            complaint = str(error).splitlines()[-1].split("] ")[-1]
            raise self._error("options that this PETSc knows", complaint) from error
        finally:
            self._unused = {name for name in self._unused if not _was_used(name)}
            for name in set(database.getAll()) - set(before):
                database.delValue(name)
            for name, value in before.items():
                database.setValue(name, value)

    def check_all_used(self) -> None:
        """Refuse names that PETSc has not asked for, now that it has solved.

        Raises
        ------
        InputError
            There is one.
        """
        for name in sorted(self._unused):
            raise self._error("options that this PETSc knows", f"-{name} is not one of those used")

    def _error(self, expected: str, found: str) -> InputError:
        return InputError(f"solver.petsc_options = {self._text!r}: expected {expected} ({found})")


def _was_used(name: str) -> bool:
    """Whether PETSc has asked for an option; petsc4py does not hand this on."""
    used = ctypes.c_int(0)
    ctypes.CDLL(PETSc.__file__).PetscOptionsUsed(None, name.encode(), ctypes.byref(used))
    return bool(used.value)
