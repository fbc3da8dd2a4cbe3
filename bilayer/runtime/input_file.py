"""A file that is read: a regular file of this machine, refused before it is opened if it is none.

A pipe or a device would be waited for or read without an end, and a library might take an address
for a file. Every reader of the project opens its files here. The reason of a refusal is the
system's own.
"""

import codecs
import errno
import os
import re
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bilayer.errors import InputError

LARGEST_TEXT = 2**26
"""Bytes of a specimen file, a study file or a record that are read."""
ADDRESS = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*://")
DESCRIPTORS = tuple(folder for folder in ("/proc/self/fd", "/dev/fd") if Path(folder).is_dir())
"""Folders in which the system names the files that this process has open."""
_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


@contextmanager
def open_input(path: str | Path, what: str, largest: int | None = None) -> Iterator[int]:
    """Give the descriptor of a file that is open for reading.

    Parameters
    ----------
    path : path-like
        The file.
    what : str
        What it is, for the messages: "result file", "specimen file", ...
    largest : int, optional
        Bytes that it may have.

    Raises
    ------
    InputError
        It is missing, no regular file, larger, or cannot be opened; with the system's reason.
    """
    try:
        _check_kind(Path(path).stat(), largest)
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError, TypeError) as error:  # ValueError: of a NUL in the name
        raise unreadable(path, what, _reason(path, error)) from error
    try:
        yield descriptor
    finally:
        os.close(descriptor)


def read_text(
    path: str | Path, what: str, encoding: str = "utf-8-sig", largest: int | None = LARGEST_TEXT
) -> str:
    """Return the text of a file.

    Parameters
    ----------
    path, what, largest
        As for `open_input`.
    encoding : str
        Of the text.

    Raises
    ------
    InputError
        The file cannot be read, or holds no text.
    """
    with open_input(path, what, largest) as descriptor:
        try:
            with open(descriptor, encoding=encoding, closefd=False) as file:
                return file.read()
        except UnicodeDecodeError as error:
            reason = f"not a text file: {error.reason}"
            if error.object.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
                reason = "is UTF-16, as `>` of PowerShell writes it, expected UTF-8"
            raise unreadable(path, what, reason) from error
        except OSError as error:
            raise unreadable(path, what, _reason(path, error)) from error


def name_of_open_file(descriptor: int, path: str | Path) -> str:
    """Return a name for an open file that any library can open again.

    It is plain ASCII, and no library takes it for an address, whatever the file's own name.
    """
    return f"{DESCRIPTORS[0]}/{descriptor}" if DESCRIPTORS else str(Path(path).absolute())


def unreadable(path: str | Path, what: str, reason: str) -> InputError:
    """Return the error of a file that cannot be read, for a reason."""
    return InputError(f"{what} {path}: cannot be read ({reason})")


def kind_of(found: os.stat_result) -> str:
    """Return what is found where a regular file should be: "a device", "a folder", ..."""
    return _KINDS.get(stat.S_IFMT(found.st_mode), "no regular file")


def _check_kind(found: os.stat_result, largest: int | None) -> None:
    """Raise OSError unless a regular file is found, not larger than the largest."""
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, f"is {kind_of(found)}, expected a file")
    if largest is not None and found.st_size > largest:
        raise OSError(errno.EFBIG, f"has {found.st_size} bytes, expected at most {largest}")


def _reason(path: str | Path, error: Exception) -> str:
    if ADDRESS.match(str(path)):
        return "is an address, expected a file of this machine"
    return str((error.strerror if isinstance(error, OSError) else None) or error)
