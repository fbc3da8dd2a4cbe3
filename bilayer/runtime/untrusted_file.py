"""Files of unknown origin that a library reads: behind the gate, in a child process, in time."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from bilayer.runtime.child_process import ChildProcessDiedError, run_in_child
from bilayer.runtime.input_file import open_input, unreadable
from bilayer.runtime.memory import available_memory

Found = TypeVar("Found")


def read_in_child(
    path: str | Path,
    what: str,
    read: Callable[[], Found],
    shortest_time: float,
    bytes_per_second: float,
) -> Found:
    """Return what a function reads from a file, in a child process; raise what it raises there.

    Parameters
    ----------
    path : path-like
        The file.
    what : str
        What it is, for the messages: "mesh file", "drawing", ...
    read : callable
        Opens the file by its path. What it returns can be pickled.
    shortest_time : float
        Seconds that any file may take; a large one gets more.
    bytes_per_second : float
        How much more.

    Raises
    ------
    InputError
        It is no regular file or cannot be opened; or reading it takes too long, or ends the child.
    """
    with open_input(path, what) as descriptor:
        seconds = shortest_time + os.fstat(descriptor).st_size / bytes_per_second
    try:
        return run_in_child(read, seconds, available_memory())
    except ChildProcessDiedError as error:
        raise unreadable(path, what, f"reading it {error}") from error
