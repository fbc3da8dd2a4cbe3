"""What not every operating system has, asked for in this module alone.

Linux has all of it. macOS keeps no room on a disk and counts no cores of a process; Windows has no
locks of this kind and starts processes in another way. Each function does what the system can.
"""

import math
import multiprocessing
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.context import BaseContext
from pathlib import Path

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

_BLOCK = 2**20


def reserve_room(descriptor: int, size: int) -> None:
    """Take room on the disk for an empty file.

    Parameters
    ----------
    descriptor : int
        Of a file that is open for writing.
    size : int
        Bytes.

    Raises
    ------
    OSError
        There is no such room.
    """
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(descriptor, 0, size)
        return
    while size > 0:  # a file with a hole in it would take no room
        size -= os.write(descriptor, bytes(min(size, _BLOCK)))


def available_cores() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def process_context() -> BaseContext:
    """Return the way to start processes: not as copies of this one, which may use MPI."""
    methods = multiprocessing.get_all_start_methods()
    can_fork = hasattr(os, "fork") and "forkserver" in methods
    return multiprocessing.get_context("forkserver" if can_fork else "spawn")


@contextmanager
def hold_lock(file: Path, take: Callable[[int], bool]) -> Iterator[bool]:
    """Hold a lock that ends with this process, whatever ends it; false if another has it.

    Parameters
    ----------
    file : Path
        Made if it is missing.
    take : callable
        How to lock it: `lock_alone`, `lock_shared` or `wait_to_lock_alone`.
    """
    descriptor = os.open(file, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        yield take(descriptor)
    finally:
        os.close(descriptor)


def lock_alone(descriptor: int) -> bool:
    """Lock an open file for this process alone until it is closed; False if another one has it.

    On a file system or a system without locks it is as if nobody had it.
    """
    return fcntl is None or _lock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)


def wait_to_lock_alone(descriptor: int) -> bool:
    """Lock an open file for this process alone until it is closed, when no other one has it."""
    return fcntl is None or _lock(descriptor, fcntl.LOCK_EX)


def lock_shared(descriptor: int) -> bool:
    """Lock an open file together with others that do; wait for one that has it alone."""
    return fcntl is None or _lock(descriptor, fcntl.LOCK_SH)


def _lock(descriptor: int, operation: int) -> bool:
    try:
        fcntl.flock(descriptor, operation)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks, as some of clusters
        pass
    return True


def address_space_left(used: int) -> float:
    """Return what a limit (`ulimit -v`) leaves of the address space of this process, bytes.

    Parameters
    ----------
    used : int
        Bytes that it has.

    Returns
    -------
    float
        Infinite if there is no limit.
    """
    return _limit("RLIMIT_AS") - used


def most_open_files() -> float:
    """Return how many files this process may hold open at once (`ulimit -n`).

    Returns
    -------
    float
        Infinite if there is no limit.
    """
    return _limit("RLIMIT_NOFILE")


def _limit(name: str) -> float:
    """Return the limit of this process that holds now (not what it may be raised to)."""
    try:
        import resource
    except ImportError:  # Windows
        return math.inf
    soft, _ = resource.getrlimit(getattr(resource, name))
    return math.inf if soft == resource.RLIM_INFINITY else soft


def user_number() -> int:
    """Return the number of the user whose process this is; 0 on a system that has none."""
    return os.getuid() if hasattr(os, "getuid") else 0
