"""The cases of a study on the ranks of mpirun, in groups that each compute one case at a time.

There is no master: a counter on the first rank, which every group reads and advances, is the queue.
"""

import os
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from bilayer.errors import BilayerError
from bilayer.runtime.petsc import start_petsc
from bilayer.study.case import Case
from bilayer.study.compute import compute_case
from bilayer.study.folder import StudyFolder
from bilayer.study.neighbours import Neighbours

Prepared = TypeVar("Prepared")


def compute_on_ranks(
    world: Any,
    cases: Sequence[Case],
    folder: StudyFolder,
    ranks_per_case: int,
    told: Callable[[Case], None],
    limit: float | None = None,
) -> None:
    """Compute cases, in their order, one per group of ranks.

    Parameters
    ----------
    world : mpi4py.MPI.Comm
        All ranks; each calls with the same arguments.
    cases : sequence of Case
        The longest first is best.
    folder : StudyFolder
        Where they are kept; held by the caller.
    ranks_per_case : int
        Size of a group; the last one is smaller if the ranks do not divide.
    told : callable
        Called with each case that is over, on the ranks that computed it.
    limit : float, optional
        Seconds that a milestone may take.

    Raises
    ------
    ComputationError
        The folder cannot be written; the other groups go on.
    """
    from mpi4py.util.sync import Counter

    threading.Thread(target=_end_with_the_launcher, args=(os.getppid(),), daemon=True).start()
    start_petsc()
    group = world.Split(world.Get_rank() // ranks_per_case, world.Get_rank())
    queue = Counter(comm=world)
    failure: BilayerError | None = None
    neighbours = Neighbours()
    while failure is None:
        place = group.bcast(queue.next() if group.Get_rank() == 0 else None)
        if place >= len(cases):
            break
        failure = _first_error_of_group(group, cases[place], folder, neighbours, limit)
        told(cases[place])
    _wait_for_all(world)
    failures = [error for error in world.allgather(failure) if error is not None]
    queue.free()
    group.Free()
    if failures:
        raise failures[0]


def prepare_on_first_rank(world: Any, prepare: Callable[[], Prepared]) -> Prepared:
    """Return on every rank what `prepare` returns, or raise what it raises, on the first.

    Parameters
    ----------
    world : mpi4py.MPI.Comm
        All ranks.
    prepare : callable
        Called on the first rank alone.
    """
    outcome: Any = None
    if world.Get_rank() == 0:
        try:
            outcome = prepare()
        except BilayerError as error:
            outcome = error
    outcome = world.bcast(outcome)
    if isinstance(outcome, BilayerError):
        raise outcome
    return outcome  # type: ignore[no-any-return]


def _end_with_the_launcher(launcher: int) -> None:
    """End this rank when mpirun was killed: it would wait for ever, and hold the folder."""
    while os.getppid() == launcher:
        time.sleep(1.0)
    os._exit(1)


def _wait_for_all(world: Any) -> None:
    """Leave the core to others until the last rank is done: MPI's own waiting takes all of it."""
    arrived = world.Ibarrier()
    while not arrived.Test():
        time.sleep(0.02)


def _first_error_of_group(
    group: Any, case: Case, folder: StudyFolder, neighbours: Neighbours, limit: float | None
) -> BilayerError | None:
    """Compute a case; return the error that the first rank of the group met in keeping it."""
    failure = None
    try:
        compute_case(case, folder, group, neighbours, limit)
    except BilayerError as error:
        failure = error
    met: BilayerError | None = group.bcast(failure)
    return met
