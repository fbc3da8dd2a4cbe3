"""The ranks of `mpirun`, as far as the command line is concerned: one of them speaks and writes."""

import contextlib
import sys
from typing import Any


def join_mpi() -> None:
    """Start MPI where it is installed, so that only one of several ranks speaks and writes."""
    with contextlib.suppress(ImportError):
        import mpi4py.MPI  # noqa: F401


def is_first_rank() -> bool:
    """Whether this process is the one that speaks and writes: rank 0, or alone."""
    return _world_rank() == 0


def _world_rank() -> int:
    communicator = _communicator()
    return 0 if communicator is None else communicator.Get_rank()


def world_of_ranks() -> Any:
    """Return COMM_WORLD where several ranks are in it, else None."""
    communicator = _communicator()
    return None if communicator is None or communicator.Get_size() == 1 else communicator


def _communicator() -> Any:
    """Return COMM_WORLD where MPI is in use in this process, else None."""
    mpi = sys.modules.get("mpi4py.MPI")
    return None if mpi is None else mpi.COMM_WORLD


def abort_other_ranks() -> None:
    """End the ranks that would wait for ever for one that met an unexpected error."""
    communicator = world_of_ranks()
    if communicator is not None:
        communicator.Abort(1)
