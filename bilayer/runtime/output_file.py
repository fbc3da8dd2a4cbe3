"""A file that appears whole or not at all: written in a folder beside it, then moved."""

import errno
import glob
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bilayer.errors import InputError, NotWrittenError

HDF5_ROOM = 2**16
"""Bytes that an HDF5 file may take beside its data, uncompressed."""
OF_THE_DISK = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS)
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
    target = Path(path)
    check_writable(target)
    folder = ""
    try:
        with tempfile.TemporaryDirectory(
            prefix=f".{target.stem[:NAME_SHOWN]}.", dir=target.parent
        ) as folder:
            _check_room(Path(folder), room)
            yield Path(folder, target.name)
            for written in Path(folder).iterdir():
                written.replace(target.with_name(written.name))
    except OSError as error:
        if not _is_of_writing(error, folder):
            raise
        raise NotWrittenError(f"{what} {target}: cannot be written ({error})") from error


def _is_of_writing(error: OSError, folder: str) -> bool:
    """Whether an error is of a file in the folder, or of the disk: that is full, or worn out."""
    named = isinstance(error.filename, (str, os.PathLike)) and os.fspath(error.filename)
    return not folder or error.errno in OF_THE_DISK or str(named).startswith(folder)


def _check_room(folder: Path, size: int) -> None:
    """Raise OSError unless a file of this size can be made in the folder."""
    if size > 0:
        with tempfile.TemporaryFile(dir=folder) as trial:
            os.posix_fallocate(trial.fileno(), 0, size)


def remove_leftovers(path: str | Path) -> None:
    """Remove what a process that was killed while it wrote a file has left beside it."""
    target = Path(path)
    for folder in target.parent.glob(f".{glob.escape(target.stem[:NAME_SHOWN])}.????????"):
        if folder.is_dir() and all(part.stem == target.stem for part in folder.iterdir()):
            shutil.rmtree(folder, ignore_errors=True)


def check_writable(path: Path) -> None:
    """Raise InputError unless a file can be made in the folder of `path`."""
    folder = path.parent
    try:
        if not folder.is_dir():
            raise InputError(f"output file {path}: the folder {folder} does not exist")
        if path.is_dir():
            raise InputError(f"output file {path}: is a folder, expected a file name")
        with suppress(FileNotFoundError):
            path.lstat()  # refuses a name that is too long
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise InputError(f"output file {path}: cannot be made ({error.strerror})") from error
