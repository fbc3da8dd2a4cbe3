"""The ranks of `mpirun`, as far as the command line is concerned: one of them speaks and writes."""

import contextlib
import os
import sys
from collections.abc import Callable
from typing import Any

from bilayer.errors import BilayerError, ComputationError
from bilayer.runtime.petsc import start_petsc
from bilayer.runtime.surroundings import variables_changed
from bilayer.runtime.temporary_folder import take_usable_temporary_folder

LAUNCHERS = ("OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK")
"""Variables by which mpirun, or srun in its place, tells a process its rank."""


def join_mpi() -> None:
    """Start MPI if it is installed, so that only one of several ranks speaks and writes."""
    take_usable_temporary_folder()
    with contextlib.suppress(ImportError):
        with variables_changed(_ways_to_others()):
            import mpi4py.MPI

        if mpi4py.MPI.COMM_WORLD.Get_size() > 1:
            start_petsc()


def _ways_to_others() -> dict[str, str | None]:
    """Return changes of the variables by which Open MPI reaches other ranks: none if there are.

    A process without others needs no way to them. A limit, a full disk or an odd value of such a
    variable would end in a report of Open MPI's own.
    """
    if any(launcher in os.environ for launcher in LAUNCHERS):
        return {}
    hidden = dict.fromkeys(name for name in os.environ if name.startswith("OMPI_MCA_"))
    return {**hidden, "OMPI_MCA_btl": "self", "OMPI_MCA_pml": "ob1"}


def is_first_rank() -> bool:
    """Whether this process is the one that speaks and writes: rank 0, or alone."""
    return _world_rank() == 0


def has_other_ranks() -> bool:
    """Whether this process computes together with others."""
    communicator = _communicator()
    return communicator is not None and communicator.Get_size() > 1


def _world_rank() -> int:
    communicator = _communicator()
    return 0 if communicator is None else communicator.Get_rank()


def world_of_ranks() -> Any:
    """Return COMM_WORLD in a process that mpirun has started, also as the only one, else None.

    Such a process starts no others: they would pass for its rank, and MPI wait for them at its end.
    """
    return _communicator() if any(name in os.environ for name in LAUNCHERS) else None


def on_first_rank(comm: Any, action: Callable[[], None]) -> None:
    """Do something on the first of some ranks; raise on all of them what it raises.

    Parameters
    ----------
    comm : mpi4py.MPI.Comm or None
        All of them call; None: this process alone.
    action : callable
        Called on the first rank.

    Raises
    ------
    BilayerError
        As raised by the action.
    ComputationError
        On the other ranks, if the action raised anything else.
    """
    if comm is None or comm.Get_size() == 1:
        action()
        return
    failure: Exception | None = None
    if comm.Get_rank() == 0:
        try:
            action()
        except Exception as error:
            failure = error
    told = failure
    if failure is not None and not isinstance(failure, BilayerError):
        told = ComputationError(f"on the first rank: {type(failure).__name__}: {failure}")
    told = comm.bcast(told)
    if failure is not None:
        raise failure
    if told is not None:
        raise told


def _communicator() -> Any:
    """Return COMM_WORLD if MPI is in use in this process, else None."""
    mpi = sys.modules.get("mpi4py.MPI")
    return None if mpi is None else mpi.COMM_WORLD


def abort_other_ranks() -> None:
    """End the ranks that would wait for ever for one that met an unexpected error."""
    if has_other_ranks():
        _communicator().Abort(1)
