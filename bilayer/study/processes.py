"""The cases of a study on the cores of one machine, a process for each.

Every process is a pool of its own, so that when one dies (a crash in a compiled library, the
system short of memory) it is known which case it was computing, and the others go on.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager
from functools import cache

from bilayer.runtime.system import process_context
from bilayer.runtime.temporary_folder import (
    LONGEST_FOR_SOCKETS,
    take_usable_temporary_folder,
)
from bilayer.runtime.termination import signals_put_off
from bilayer.study.case import Case
from bilayer.study.compute import compute_case
from bilayer.study.folder import StudyFolder
from bilayer.study.neighbours import Neighbours
from bilayer.study.records import CASE_DIED

DIED = "the process that computed it died: a crash in a compiled library, or killed from outside"


def compute_in_processes(
    cases: Sequence[Case],
    folder: StudyFolder,
    jobs: int,
    memory: float,
    told: Callable[[Case], None],
    limit: float | None = None,
) -> None:
    """Compute cases, in their order, as many at a time as the processes and the memory allow.

    Parameters
    ----------
    cases : sequence of Case
        The longest first is best.
    folder : StudyFolder
        Where they are kept; held by the caller.
    jobs : int
        Largest number of processes.
    memory : float
        Bytes that the processes may take together; a case that takes more is computed alone.
    told : callable
        Called with each case that has ended, well or not.
    limit : float, optional
        Seconds that a milestone may take.

    Raises
    ------
    ComputationError
        The folder cannot be written; the cases that run at that moment are finished first.
    KeyboardInterrupt
        The processes have ended; the cases that they computed have their milestones so far.
    """
    waiting = deque(cases)
    running: dict[Future[None], tuple[ProcessPoolExecutor, Case]] = {}
    idle: list[ProcessPoolExecutor] = []

    def next_starts() -> bool:
        taken = sum(case.memory for _, case in running.values())
        fits = not running or taken + waiting[0].memory <= memory
        return len(running) < jobs and fits

    with ExitStack() as workers, _ended_by_ctrl_c(folder, running):
        while waiting or running:
            while waiting and next_starts():
                case = waiting.popleft()
                worker = idle.pop() if idle else workers.enter_context(_worker(folder))
                running[worker.submit(_compute, case, folder, limit)] = worker, case
            while idle:
                idle.pop().shutdown()  # nothing fits beside what runs: give its memory back
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                worker, case = running.pop(future)
                try:
                    future.result()
                    idle.append(worker)
                except BrokenProcessPool:
                    folder.keep_failure(case, DIED, status=CASE_DIED)
                told(case)


@contextmanager
def _ended_by_ctrl_c(
    folder: StudyFolder, running: Mapping[Future[None], tuple[ProcessPoolExecutor, Case]]
) -> Iterator[None]:
    """End the processes of the block at Ctrl-C, and remove what they have written by half."""
    try:
        yield
    except KeyboardInterrupt:
        with signals_put_off():
            processes = multiprocessing.active_children()
            for process in processes:
                process.kill()
            for process in processes:
                process.join()
            for _, case in running.values():
                folder.remove_half_written(case)
        raise


def _worker(folder: StudyFolder) -> ProcessPoolExecutor:
    take_usable_temporary_folder(LONGEST_FOR_SOCKETS)
    context = process_context()
    if context.get_start_method() == "forkserver":
        context.set_forkserver_preload([__name__])
    return ProcessPoolExecutor(1, context, initializer=_begin_work, initargs=(folder,))


def _compute(case: Case, folder: StudyFolder, limit: float | None) -> None:
    """Compute a case in a worker, beside those that it has computed before."""
    compute_case(case, folder, neighbours=_neighbours_of_this_process(), limit=limit)


@cache
def _neighbours_of_this_process() -> Neighbours:
    return Neighbours()


def _begin_work(folder: StudyFolder) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal's is for the study, which ends this
    threading.Thread(target=_live_with_the_study, args=(folder,), daemon=True).start()


def _live_with_the_study(folder: StudyFolder) -> None:
    """Mark this process as a writer in the folder, and end it when the study's process ends."""
    study = multiprocessing.parent_process()
    assert study is not None, "a worker is started by the study"
    with folder.mark_as_working():
        study.join()
        os._exit(1)
