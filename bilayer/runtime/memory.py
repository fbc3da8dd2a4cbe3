"""The memory that is available to a computation, on one machine or on those of its ranks."""

from collections.abc import Callable
from typing import Any


def ranks_of_this_machine(comm: Any) -> Any:
    """Return the communicator of the ranks that share this rank's memory."""
    from mpi4py import MPI

    return comm.Split_type(MPI.COMM_TYPE_SHARED)


def available_memory(
    comm: Any = None, machine_of: Callable[[Any], Any] = ranks_of_this_machine
) -> int:
    """Return the memory that is available, bytes.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm, optional
        The ranks that share a model, possibly on several machines: each machine counts once. All
        of them call. This machine alone if left out.
    machine_of : callable
        Returns the communicator of the ranks on the same machine.
    """
    import psutil

    here = int(psutil.virtual_memory().available)
    if comm is None or comm.Get_size() == 1:
        return here
    machine = machine_of(comm)
    speaks_for_it = machine.Get_rank() == 0
    machine.Free()
    return int(comm.allreduce(here if speaks_for_it else 0))
