"""The compiled forms: how they are compiled, and where they are kept.

The sums of the kernels may be added up in any order, which lets the compiler compute several terms
at once; infinities and NaNs, which tell of elements turned inside out, stay what they are. Options
for the machine at hand (-march=native) gain little more and would keep the compiled forms from
being used by every machine that shares a home folder.

dolfinx and FFCx would also read options from files of the user and of the current folder, and a
result would not tell of them. All options are given here, and these take precedence.
"""

import os
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import ffcx.options
from dolfinx import fem
from ufl.domain import extract_unique_domain

from bilayer.errors import MachineError
from bilayer.runtime.machine_faults import is_of_the_machine
from bilayer.runtime.system import hold_lock, user_number, wait_to_lock_alone

SUMS_IN_ANY_ORDER = [
    "-fassociative-math",
    "-fno-signed-zeros",
    "-fno-trapping-math",
    "-freciprocal-math",
    "-fno-math-errno",
]

JIT_OPTIONS: dict[str, Any] = {
    "cffi_extra_compile_args": ["-O2", *SUMS_IN_ANY_ORDER, "-g0"],
    "cffi_debug": False,
    "cffi_verbose": False,
    "cffi_libraries": None,
    "timeout": 600,  # s, for the rank that compiles; the default of 10 s is less than it takes
}


def compiled_form(integral: Any) -> Any:
    """Return a form of dolfinx, compiled or as it is kept from an earlier run.

    Parameters
    ----------
    integral : ufl.Form
        What is to be integrated.

    Raises
    ------
    MachineError
        A file of options of dolfinx or FFCx cannot be read, or the compiler does not work.
    """
    with _compiling_alone(integral.ufl_domain().ufl_cargo().comm):
        return _compile(fem.form, integral)


def compiled_expression(expression: Any, points: Any) -> Any:
    """Return an expression of dolfinx at points of the reference cell; see `compiled_form`."""
    with _compiling_alone(extract_unique_domain(expression).ufl_cargo().comm):
        return _compile(fem.Expression, expression, points)


def _compile(compiler: Callable[..., Any], *what: Any) -> Any:
    jit_options = JIT_OPTIONS | {"cache_dir": folder_of_forms()}
    try:
        return compiler(*what, form_compiler_options=_form_options(), jit_options=jit_options)
    except Exception as error:
        _tell_of_the_machine(error)
        raise


@contextmanager
def _compiling_alone(comm: Any) -> Iterator[None]:
    """Let one process at a time compile, and remove what a killed one has left half compiled.

    FFCx takes such a leftover for a compilation under way, and waits for its end until `timeout`.
    """
    if comm.rank > 0:  # the first rank compiles, the others wait for it
        yield
        return
    folder = folder_of_forms()
    with hold_lock(folder / "lock", wait_to_lock_alone):
        for source in folder.glob("libffcx_*.c"):
            if not source.with_suffix(".c.cached").exists():
                source.unlink(missing_ok=True)
        yield


def _tell_of_the_machine(error: Exception) -> None:
    """Raise MachineError for an error of what compiles the forms, and not of a form.

    The ranks that do not compile know of it by its words alone.
    """
    if type(error).__name__ in ("JSONDecodeError", "UnicodeDecodeError"):
        raise MachineError(
            f"dolfinx_jit_options.json or ffcx_options.json, in the current folder or under "
            f"~/.config, cannot be read ({error}); expected JSON, or no such file"
        ) from error
    if is_of_the_machine(error) or "just-in-time compilation" in str(error).lower():
        words = next(iter(str(error).splitlines()), "") or type(error).__name__
        raise MachineError(
            f"the finite-element forms cannot be compiled ({words}); expected a C compiler that "
            "works, and Python with its header files"
        ) from error


@cache
def folder_of_forms() -> Path:
    """Return the folder in which compiled forms are kept.

    It is `fenics/bilayer-shells` in the user's cache folder, beside the forms of other programs, or
    else, if nothing can be written there, in a folder for temporary files that is the user's alone:
    code is loaded from it.

    Raises
    ------
    MachineError
        There is neither.
    """
    named = os.environ.get("XDG_CACHE_HOME", "")
    usual = Path(named if Path(named).is_absolute() else Path.home() / ".cache")
    usual = usual / "fenics" / "bilayer-shells"
    own = Path(tempfile.gettempdir()) / f"bilayer-shells-{user_number()}"
    try:
        usual.mkdir(parents=True, exist_ok=True)
        if os.access(usual, os.W_OK | os.X_OK):
            return usual
    except OSError:
        pass
    try:
        own.mkdir(mode=0o700, exist_ok=True)
        found = own.lstat()
    except OSError as error:
        raise MachineError(
            f"the compiled forms cannot be kept in {usual} or {own} ({error.strerror}); set "
            "XDG_CACHE_HOME to a folder that can be written"
        ) from error
    if found.st_uid != user_number() or found.st_mode & 0o077 or own.is_symlink():
        raise MachineError(
            f"the compiled forms cannot be kept in {usual}, and {own} is not this user's alone; "
            "set XDG_CACHE_HOME to a folder that can be written"
        )
    return own


def _form_options() -> dict[str, Any]:
    """Return the options of FFCx without any file; the kind of scalar is set by dolfinx."""
    return {
        name: entry[1]
        for name, entry in ffcx.options.FFCX_DEFAULT_OPTIONS.items()
        if name != "scalar_type"
    }
