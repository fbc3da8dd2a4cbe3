"""The memory that is available to a computation, on one machine or on those of its ranks."""

from typing import Any

import psutil


def available_memory(comm: Any = None) -> int:
    """Return the memory that is available, bytes.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm, optional
        The ranks that share a model, possibly on several machines: each machine counts once. All
        of them call. This machine alone where left out.
    """
    here = int(psutil.virtual_memory().available)
    if comm is None or comm.Get_size() == 1:
        return here
    from mpi4py import MPI

    machine = comm.Split_type(MPI.COMM_TYPE_SHARED)
    speaks_for_it = machine.Get_rank() == 0
    machine.Free()
    return int(comm.allreduce(here if speaks_for_it else 0))
