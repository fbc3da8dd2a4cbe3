"""A file that appears whole or not at all: written in a folder beside it, then moved.

`check_writable` is the gate of every output: it is passed before anything is computed. A symbolic
link stays, and what it points at is written. Nothing but a regular file is ever replaced.
"""

import errno
import glob
import os
import shutil
import stat
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bilayer.errors import InputError, NotWrittenError
from bilayer.runtime.input_file import DESCRIPTORS, kind_of
from bilayer.runtime.system import reserve_room

HDF5_ROOM = 2**16
"""Bytes that an HDF5 file may take beside its data, uncompressed."""
OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
PLAIN_STEM = "written"
"""Name within that folder of a file whose own name libraries do not take: it is not in UTF-8."""
NAME_SHOWN = 32
"""Letters of a file's name in that of the folder it is written in, which must not be too long."""


@contextmanager
def whole_file(path: str | Path, what: str, room: int = 0) -> Iterator[Path]:
    """Give a name of the same ending to write to; move what was written when the block ends well.

    Companions that a format writes beside its file (the .h5 of an .xdmf) move along.

    Parameters
    ----------
    path : path-like
        Where the file shall be; an earlier one stays as it was until the new one is whole.
    what : str
        What it is, for the messages: "result file", "figure", ...
    room : int
        Bytes that the disk must still hold when the block begins: for HDF5, which may end the
        process when it meets a full disk (version 2 does).

    Raises
    ------
    InputError
        The folder does not exist or cannot be written.
    NotWrittenError
        Writing failed, for example on a full disk. Any other error of the block passes as it is.
    """
    target = check_writable(path)
    places: tuple[str, ...] = ()
    try:
        name = _plain_name(Path(path))
        with _folder_beside(target, name) as (folder, shown):
            places = str(folder), str(shown)
            _check_room(folder, room)
            yield shown / name
            for written in folder.iterdir():
                _move(written, target if written.name == name else target.with_name(written.name))
    except OSError as error:
        if not _is_of_writing(error, places):
            raise
        raise NotWrittenError(f"{what} {path}: cannot be written ({error})") from error


@contextmanager
def trial_file(path: str | Path) -> Iterator[Path]:
    """Give a name as `whole_file` does; what is written there is removed, and no file replaced."""
    name = _plain_name(Path(path))
    with _folder_beside(check_writable(path), name) as (_, shown):
        yield shown / name


@contextmanager
def _folder_beside(target: Path, name: str) -> Iterator[tuple[Path, Path]]:
    """Give a new folder beside a file, and a name of it that any library takes."""
    prefix = f".{Path(name).stem[:NAME_SHOWN]}."
    with tempfile.TemporaryDirectory(prefix=prefix, dir=target.parent) as made:
        folder = Path(made)
        if _is_utf8(made) or not DESCRIPTORS:
            yield folder, folder
            return
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            yield folder, Path(DESCRIPTORS[0], str(descriptor))
        finally:
            os.close(descriptor)


def _plain_name(path: Path) -> str:
    """Return the name of a file, or one in its place that is in UTF-8."""
    return path.name if _is_utf8(path.name) else f"{PLAIN_STEM}{path.suffix}"


def _is_utf8(name: str) -> bool:
    """Whether a name of the file system, as Python holds it, is in UTF-8."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return True


def _move(written: Path, target: Path) -> None:
    """Put a file in its place, with the access rights of the one that was there."""
    with suppress(OSError):
        shutil.copymode(target, written)
    written.replace(target)


def _is_of_writing(error: OSError, places: tuple[str, ...]) -> bool:
    """Whether an error is of a file in the folder, or of the disk: that is full, or worn out."""
    named = isinstance(error.filename, (str, os.PathLike)) and os.fspath(error.filename)
    return not places or error.errno in OF_THE_DISK or str(named).startswith(places)


def _check_room(folder: Path, size: int) -> None:
    """Raise OSError unless a file of this size can be made in the folder."""
    if size > 0:
        with tempfile.TemporaryFile(dir=folder) as trial:
            reserve_room(trial.fileno(), size)


def remove_leftovers(path: str | Path) -> None:
    """Remove what a process that was killed while it wrote a file has left beside it."""
    target = Path(os.path.realpath(path))
    stem = Path(_plain_name(Path(path))).stem
    for folder in target.parent.glob(f".{glob.escape(stem[:NAME_SHOWN])}.????????"):
        if folder.is_dir() and all(part.stem == stem for part in folder.iterdir()):
            shutil.rmtree(folder, ignore_errors=True)


def check_writable(path: str | Path, inputs: Iterable[str | Path] = ()) -> Path:
    """Return the file that is written for a path: what it points at if it is a symbolic link.

    Parameters
    ----------
    path : path-like
        The output.
    inputs : iterable of path-like
        Files that are read and must not be lost.

    Raises
    ------
    InputError
        The name is empty, the folder is missing or cannot be written, or there is something that
        must not be replaced: a folder, a device, a pipe, a file without write permission, an
        input. The reason is the system's own.
    """
    field = f"output file {path}"
    if not os.fspath(path):
        raise InputError("output file '': expected a file name")
    try:
        target = Path(os.path.realpath(path))
        there = _stat(Path(path))
        if there is not None:
            _check_replaceable(field, target, there)
            for given in inputs:
                held = _stat(Path(given))
                if held is not None and os.path.samestat(there, held):
                    raise InputError(
                        f"{field}: is read as the input {given}, expected another name"
                    )
        if not target.parent.is_dir():
            folder = target.parent if Path(path).is_symlink() else Path(path).parent
            raise InputError(f"{field}: the folder {folder} does not exist")
        with tempfile.TemporaryFile(dir=target.parent):
            pass
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        reason = error.strerror if isinstance(error, OSError) else error
        raise InputError(f"{field}: cannot be made ({reason})") from error
    return target


def _stat(path: Path) -> os.stat_result | None:
    """Return what there is at a path, None if it is free; refuses a name that is too long."""
    try:
        return path.stat()
    except FileNotFoundError:
        return None


def _check_replaceable(field: str, target: Path, there: os.stat_result) -> None:
    if not stat.S_ISREG(there.st_mode):
        raise InputError(f"{field}: is {kind_of(there)}, expected a file name")
    if not os.access(target, os.W_OK):
        raise InputError(f"{field}: is there and cannot be written (Permission denied)")
