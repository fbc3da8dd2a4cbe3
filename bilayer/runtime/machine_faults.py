"""Whether an error is the machine's and not that of what is computed.

It passes when the machine is mended: its memory, its disks, its libraries, its compiler. So nothing
is held against a case for it.
"""

import re
from collections.abc import Iterator

from bilayer.errors import MachineError, NotEnoughMemoryError

_OF_MEMORY = re.compile(
    r"MemoryError|out of memory|cannot allocate memory|bad_alloc|malloc|memory needed than allowed",
    re.IGNORECASE,
)
"""In the words of PETSc, MUMPS, HDF5, gmsh and the system."""
_OF_THE_COMPILER = ("cffi", "ply", "pycparser", "distutils", "setuptools", "_distutils_hack")
"""Packages that compile the finite-element forms."""


def tells_of_memory(words: str) -> bool:
    """Whether the words of an error say that there was not enough memory."""
    return _OF_MEMORY.search(words) is not None


def lacks_memory(error: BaseException) -> bool:
    """Whether an error, or what caused it, is a lack of memory."""
    return any(
        isinstance(link, (MemoryError, NotEnoughMemoryError)) or tells_of_memory(str(link))
        for link in _chain(error)
    )


def is_of_the_machine(error: BaseException) -> bool:
    """Whether an error, or what caused it, is of a file, a library or a compiler of the machine."""
    return any(
        isinstance(link, (MachineError, OSError, ImportError))
        or type(link).__module__.partition(".")[0] in _OF_THE_COMPILER
        for link in _chain(error)
    )


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error, what caused it, and so on."""
    while error is not None:
        yield error
        error = error.__cause__
