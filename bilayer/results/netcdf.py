"""NetCDF files of unknown origin: opened and read in a child process, which a damaged one may kill.

The HDF5 library trusts the bytes of a file. One flipped bit may make it crash, loop or take all
memory. So what a file holds comes to this process as plain arrays, and the library of this process
never meets a file that it did not write.
"""

import os
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import netCDF4
import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray.backends.locks import HDF5_LOCK

from bilayer.errors import InputError
from bilayer.runtime.child_process import ChildProcessDiedError, outcomes_of_child
from bilayer.runtime.input_file import name_of_open_file, open_input, unreadable
from bilayer.runtime.memory import available_memory

Found = TypeVar("Found")

HDF5, CLASSIC = b"\x89HDF\r\n\x1a\n", (b"CDF\x01", b"CDF\x02", b"CDF\x05")
"""First bytes of the two formats of NetCDF."""
SHORTEST_TIME, BYTES_PER_SECOND = 10.0, 5e6
"""Seconds that a file may take to be read: so many, and longer the larger it is."""
BYTES_OF_THE_LIBRARY = 2**28
LARGEST_RATIO = 1100
"""Bytes of data for each byte of a file: zlib packs at most 1032 of them into one."""


def read_netcdf(path: str | Path, what: str, read: Callable[[netCDF4.Dataset], Found]) -> Found:
    """Return what a function reads from a NetCDF file.

    Parameters
    ----------
    path : path-like
        The file.
    what : str
        What it is, for the messages: "result file".
    read : callable
        Called in a child process with the open file. What it returns can be pickled.

    Raises
    ------
    InputError
        The file cannot be read, with the reason.
    """
    (found,) = read_netcdf_files([path], what, read)
    if isinstance(found, InputError):
        raise found
    return found


def read_netcdf_files(
    paths: Iterable[str | Path], what: str, read: Callable[[netCDF4.Dataset], Found]
) -> list[Found | InputError]:
    """Return what a function reads from each of some files, or why it cannot be read.

    See `read_netcdf`. They share one child process, as long as none of them kills it.
    """
    waiting, found = list(paths), []
    memory = available_memory()
    while waiting:
        seconds = SHORTEST_TIME + max(map(_size, waiting)) / BYTES_PER_SECOND
        rest = tuple(waiting)
        outcomes = outcomes_of_child(partial(_read_all, rest, what, read, memory), seconds, memory)
        try:
            with HDF5_LOCK, closing(outcomes):  # at rest while the process is copied
                for outcome in outcomes:
                    found.append(outcome)
                    waiting.pop(0)
        except ChildProcessDiedError as error:
            reason = f"reading it {error}"
            found.append(unreadable(waiting.pop(0), what, reason))
    return found


@dataclass(frozen=True, eq=False)
class StoredGroup:
    """A file, or a group of it, as it is stored.

    Parameters
    ----------
    variables : mapping of str to tuple
        For each name its dimensions, values and attributes.
    attributes : mapping of str to Any
        Of the group.
    sizes : mapping of str to int
        Of all its dimensions.
    headers : mapping of str to tuple
        For each name in it, also those whose values are not here: dimensions, shape and type.
    """

    variables: Mapping[str, tuple[tuple[str, ...], NDArray[Any], Mapping[str, Any]]]
    attributes: Mapping[str, Any]

    sizes: Mapping[str, int]
    headers: Mapping[str, tuple[tuple[str, ...], tuple[int, ...], Any]]

    @classmethod
    def of(cls, group: netCDF4.Dataset, dims: Container[Any] | None = None) -> "StoredGroup":
        """Return what a group holds, in memory; within the `read` of `read_netcdf`.

        Parameters
        ----------
        group : netCDF4.Dataset
            Open.
        dims : container of tuple of str, optional
            Only the variables whose dimensions are one of these.
        """
        group.set_auto_maskandscale(False)
        group.set_auto_chartostring(False)
        return cls(
            {
                name: (variable.dimensions, np.asarray(variable[...]), _attributes(variable))
                for name, variable in group.variables.items()
                if dims is None or variable.dimensions in dims
            },
            _attributes(group),
            {name: dimension.size for name, dimension in group.dimensions.items()},
            {
                name: (variable.dimensions, variable.shape, variable.dtype)
                for name, variable in group.variables.items()
            },
        )

    def decoded(self) -> xr.Dataset:
        """Return it as xarray understands it: gaps as NaN, coordinates set apart.

        Raises
        ------
        Exception
            Of any kind: sizes or attributes do not fit.
        """
        return xr.decode_cf(xr.Dataset(dict(self.variables), attrs=self.attributes)).load()


def _attributes(holder: Any) -> dict[str, Any]:
    return {name: holder.getncattr(name) for name in holder.ncattrs()}


def _size(path: str | Path) -> int:
    try:
        return Path(path).stat().st_size
    except (OSError, ValueError, TypeError):
        return 0


def _read_all(
    paths: Iterable[str | Path],
    what: str,
    read: Callable[[netCDF4.Dataset], Found],
    memory: int,
) -> Iterator[Found | InputError]:
    return (_read(path, what, read, memory) for path in paths)


def _read(
    path: str | Path, what: str, read: Callable[[netCDF4.Dataset], Found], memory: int
) -> Found | InputError:
    """Read a file in the child process."""
    try:
        with open_input(path, what) as descriptor:
            try:
                return _read_open(descriptor, path, read, memory)
            except Exception as error:
                reason = why_not_locked(descriptor) or _words(error)
                return unreadable(path, what, reason)
    except InputError as error:
        return error


def _read_open(
    descriptor: int, path: str | Path, read: Callable[[netCDF4.Dataset], Found], memory: int
) -> Found:
    size = os.fstat(descriptor).st_size
    _check_beginning(descriptor, size)
    with _no_other_file(), netCDF4.Dataset(name_of_open_file(descriptor, path)) as stored:
        stated = _stated_bytes(stored)
        if stated > min(memory, LARGEST_RATIO * size + BYTES_OF_THE_LIBRARY):
            raise ValueError(f"states {stated} bytes of data in a file of {size}")
        return read(stored)


@contextmanager
def _no_other_file() -> Iterator[None]:
    """Let this process open one file at a time meanwhile: an HDF5 file may name others.

    Their content would pass for its own.
    """
    try:
        import resource
    except ImportError:
        yield
        return
    free = os.dup(0)  # the lowest number that is free, which the file gets
    os.close(free)
    usual, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (free + 1, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (usual, most))


def _stated_bytes(group: netCDF4.Dataset) -> int:
    """Return the bytes that all variables of a group take in memory."""
    own = sum(_bytes_of(variable) for variable in group.variables.values())
    return own + sum(_stated_bytes(inner) for inner in group.groups.values())


def _bytes_of(variable: Any) -> int:
    each = variable.dtype.itemsize if isinstance(variable.dtype, np.dtype) else 64  # a text
    count = 1
    for length in variable.shape:
        count *= int(length)
    return count * each


def _check_beginning(descriptor: int, size: int) -> None:
    """Raise ValueError unless a file begins as NetCDF and is not cut off."""
    if size == 0:
        raise ValueError("is empty")
    begin = _bytes_at(descriptor, 0)
    if begin[:4] in CLASSIC:
        return
    place = 0
    while begin[:8] != HDF5:  # it may stand behind a block of the user's
        place = max(512, 2 * place)
        if place >= size:
            raise ValueError("is no NetCDF file, as `bilayer solve` writes")
        begin = _bytes_at(descriptor, place)
    end = _stated_end(begin)
    if end is not None and size < end:
        raise ValueError(f"is cut off: has {size} of {end} bytes")


def _bytes_at(descriptor: int, place: int) -> bytes:
    os.lseek(descriptor, place, os.SEEK_SET)
    return os.read(descriptor, 64)


def _stated_end(superblock: bytes) -> int | None:
    """Return the place of the file's end that an HDF5 superblock states, if it is as expected."""
    version = superblock[8]
    widths = {0: 13, 1: 13, 2: 9, 3: 9}
    ends = {0: 40, 1: 44, 2: 28, 3: 28}
    if version not in ends or superblock[widths[version]] != 8:
        return None
    begin = ends[version]
    return int.from_bytes(superblock[begin : begin + 8], "little")


def why_not_locked(descriptor: int) -> str:
    """Return why a lock is refused that the user's setting asks for; else an empty text."""
    if os.environ.get("HDF5_USE_FILE_LOCKING", "").upper() in ("FALSE", "0"):
        return ""
    try:
        import fcntl

        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except ImportError:
        return ""
    except OSError as error:
        return f"cannot be locked: {error.strerror}; HDF5_USE_FILE_LOCKING=FALSE does without"
    return ""


def _words(error: Exception) -> str:
    text = (error.strerror if isinstance(error, OSError) else None) or str(error)
    return " ".join(text.split()) or type(error).__name__
