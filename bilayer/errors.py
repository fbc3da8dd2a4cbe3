"""The exceptions, of two kinds: the input is bad, or the computation failed."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

INTERRUPTED = "interrupted"
"""Stop reason of a run that was told to stop."""


class BilayerError(Exception):
    """Base of every error that this project raises on purpose; its text is one line.

    Examples
    --------
    >>> import bilayer
    >>> try:
    ...     bilayer.read_specimen("missing.toml")
    ... except bilayer.BilayerError as error:
    ...     print(type(error).__name__)
    InputError
    """


class InputError(BilayerError, ValueError):
    """Bad input: the text names the field, its value and what was expected.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Disc(radius=-1.0)
    Traceback (most recent call last):
    bilayer.errors.InputError: outer_radius = -1.0 m: expected a number greater than 0
    """


@contextmanager
def fields_of(table: str) -> Iterator[None]:
    """Say of an InputError that its field is one of a table: "size = ..." is "mesh.size = ..."."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{table}.{error}") from error


class NotResumableError(InputError):
    """A file from which a run cannot go on: damaged, or of another run."""


class NotEnoughMemoryError(InputError):
    """A computation that would not fit into the memory there is now; elsewhere or later it may."""


class ComputationError(BilayerError, RuntimeError):
    """A computation or the writing of its result failed; the text says where and why.

    Examples
    --------
    >>> import bilayer
    >>> issubclass(bilayer.ComputationError, bilayer.BilayerError)
    True
    """


class MachineError(ComputationError):
    """What keeps a computation from its end is the machine: mended, or elsewhere, it may go on."""


class NotWrittenError(MachineError):
    """A file could not be written, for example on a full disk."""


class Terminated(KeyboardInterrupt):
    """SIGTERM, if it is taken as Ctrl-C."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, when some milestones were done.

    Parameters
    ----------
    result : Dataset
        With those milestones; its `stop_reason` says that it was interrupted.
    output : path-like or None
        The file that has them, too.
    """

    def __init__(self, result: Any, output: Any = None) -> None:
        super().__init__("interrupted")
        self.result, self.output = result, output
