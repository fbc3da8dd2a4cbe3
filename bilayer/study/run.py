"""A study from its plan to its index: what is missing is computed, what is there is kept."""

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import Any

import pandas as pd

from bilayer.errors import InputError
from bilayer.runtime.memory import available_memory
from bilayer.runtime.progress import Progress
from bilayer.runtime.system import available_cores
from bilayer.study.case import Case
from bilayer.study.compute import compute_case
from bilayer.study.damage import set_aside_cases, set_aside_plan, set_aside_strange
from bilayer.study.folder import StudyFolder
from bilayer.study.index import CASE_STOPPED, read_index, write_index
from bilayer.study.memory import memory_note, separate_by_memory
from bilayer.study.plan import StudyPlan
from bilayer.study.processes import compute_in_processes
from bilayer.study.rank_groups import compute_on_ranks, prepare_on_first_rank
from bilayer.study.records import CASE_FAILED, CASE_LACKS_MEMORY
from bilayer.study.script import check_script, end_if_imported_by_a_worker
from bilayer.validation import one_of

LONGEST, CHEAPEST = "longest", "cheapest"
ORDERS = {LONGEST: -1, CHEAPEST: 1}
"""The sign with which the cost of a case counts in the order of the cases."""


def run_study(
    plan: StudyPlan,
    path: Any,
    *,
    jobs: int | None = None,
    memory: float | None = None,
    retry_failed: bool = False,
    first: str = LONGEST,
    limit: float | None = None,
    progress: Progress | None = None,
    notice: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """Compute what a study's folder lacks, on the cores of this machine.

    Cases that do not fit into the memory are recorded and left for a later start.

    Parameters
    ----------
    plan : StudyPlan
        From `bilayer.study.plan.read_study`.
    path : path-like
        The study's folder, made if it is missing.
    jobs : int, optional
        Most cases computed at a time; the number of cores that this process may use if left
        out.
    memory : float, optional
        Bytes that all of them may take together; what is available if left out.
    retry_failed : bool
        Compute also those that failed or stopped early in an earlier start.
    first : {"longest", "cheapest"}
        Which cases begin: the longest, so that all cores end together; the cheapest, so that there
        is something to look at soon.
    limit : float, optional
        Seconds that a milestone may take. A case with one that takes longer stops early;
        `retry_failed` goes on there.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    notice : callable, optional
        Called with a line of text for each damaged file that is set aside, and if the memory
        allows fewer cases at a time than `jobs`.

    Returns
    -------
    DataFrame
        The index, see `bilayer.study.index`.

    Raises
    ------
    InputError
        The folder cannot be made, or a script calls this when it is imported: the processes that
        compute the cases import it, so the call belongs under `if __name__ == "__main__":`.
    ComputationError
        Another study runs in the folder, or it cannot be written any more, for example on a full
        disk; the cases that are finished stay.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> text = bilayer.specimen_to_toml(bilayer.paper_specimen())
    >>> _ = (folder / "specimen.toml").write_text(text)
    >>> _ = (folder / "study.toml").write_text('''
    ... specimen = "specimen.toml"
    ... solver = "dshell"
    ... vary = { "cut.strips" = [4, 5], "mesh.size" = [0.014], "prestretch.milestones" = [1.02] }
    ... ''')
    >>> plan = bilayer.read_study(folder / "study.toml")
    >>> index = bilayer.run_study(plan, folder / "study")  # doctest: +SKIP
    """
    end_if_imported_by_a_worker()
    check_script()
    folder, told = StudyFolder(path), notice or _tell_nobody
    set_aside_strange(folder, told)
    folder.make()
    with folder.lock_for_study():
        _put_in_order(folder, plan, told)
        waiting = cases_to_compute(plan, folder, retry_failed, first)
        count = available_cores() if jobs is None else jobs
        room = available_memory() if memory is None else memory
        fitting, shortages = separate_by_memory(waiting, room)
        for case, reason in shortages.items():
            folder.keep_failure(case, reason, status=CASE_LACKS_MEMORY)
        note = memory_note(fitting, count, room)
        if note:
            told(note)
        compute_in_processes(
            fitting, folder, count, room, _progress_reporter(fitting, progress), limit
        )
        return write_index(folder)


def run_study_on_ranks(
    plan: StudyPlan,
    path: Any,
    world: Any,
    *,
    ranks_per_case: int = 1,
    retry_failed: bool = False,
    first: str = LONGEST,
    limit: float | None = None,
    progress: Progress | None = None,
    notice: Callable[[str], None] | None = None,
) -> pd.DataFrame:
    """Compute what a study's folder lacks, on the ranks of mpirun; see `run_study`.

    Parameters
    ----------
    plan, path, retry_failed, first, limit, progress, notice
        As for `run_study`, the same on all ranks; the first reports the progress.
    world : mpi4py.MPI.Comm
        All ranks.
    ranks_per_case : int
        Ranks that share one case, if its solver can.
    """
    if ranks_per_case > world.Get_size():
        raise InputError(
            f"--ranks-per-case = {ranks_per_case}: expected at most the {world.Get_size()} ranks "
            "of mpirun"
        )
    folder, told = StudyFolder(path), notice or _tell_nobody
    with ExitStack() as held:

        def prepare() -> list[Case]:
            set_aside_strange(folder, told)
            folder.make()
            held.enter_context(folder.lock_for_study())
            _put_in_order(folder, plan, told)
            return cases_to_compute(plan, folder, retry_failed, first)

        waiting = prepare_on_first_rank(world, prepare)
        report_end = _progress_reporter(waiting, progress if world.Get_rank() == 0 else None)
        with folder.mark_as_working():
            compute_on_ranks(world, waiting, folder, ranks_per_case, report_end, limit)
        return prepare_on_first_rank(world, lambda: write_index(folder))


def run_one_case(
    plan: StudyPlan,
    path: Any,
    number: int,
    *,
    world: Any = None,
    retry_failed: bool = False,
    limit: float | None = None,
    notice: Callable[[str], None] | None = None,
) -> None:
    """Compute one case of a study by its number, unless it is there; a task of a job array.

    The index is left to the next start of the whole study.

    Parameters
    ----------
    plan, path, retry_failed, limit, notice
        As for `run_study`; the files of this case alone are set aside.
    number : int
        Place of the case in the study, from 1.
    world : mpi4py.MPI.Comm, optional
        Ranks that share the case.

    Raises
    ------
    InputError
        There is no such case.
    ComputationError
        The folder cannot be written.
    """
    if not 1 <= number <= len(plan.cases):
        raise InputError(f"--case = {number}: expected a number from 1 to {len(plan.cases)}")
    case = plan.cases[number - 1]
    folder, told = StudyFolder(path), notice or _tell_nobody

    def prepare() -> bool:
        set_aside_strange(folder, told)
        folder.make()
        set_aside_cases(folder, [case], told)
        folder.keep_plan(plan)
        return case in cases_to_compute(plan, folder, retry_failed)

    missing = prepare() if world is None else prepare_on_first_rank(world, prepare)
    if missing:
        compute_case(case, folder, world, limit=limit)


def cases_to_compute(
    plan: StudyPlan, folder: StudyFolder, retry_failed: bool, first: str = LONGEST
) -> list[Case]:
    """Return the cases that the folder lacks, the longest or the cheapest first.

    Those that were begun and never ended come last: if one of them is what brings a run down, all
    others are finished by then. `retry_failed` adds what failed or stopped early.
    """
    waiting = [
        case
        for case in plan.cases
        if not (folder.has_result(case.identity) or folder.has_failed(case.identity))
    ]
    if retry_failed:
        index = read_index(folder)
        failed = set(index["case"][index["status"].isin([CASE_FAILED, CASE_STOPPED])])
        waiting += [case for case in plan.cases if case.identity in failed]
    suspects = folder.begun_without_end()
    sign = ORDERS[one_of("first", first, ORDERS)]
    return sorted(waiting, key=lambda case: (case.identity in suspects, sign * case.cost))


def _put_in_order(folder: StudyFolder, plan: StudyPlan, told: Callable[[str], None]) -> None:
    """Remove what is left of killed processes, set aside what is damaged, and keep the plan."""
    folder.remove_leftovers()
    set_aside_plan(folder, told)
    set_aside_cases(folder, plan.cases, told)
    folder.keep_plan(plan)


def _tell_nobody(line: str) -> None:
    pass


def _progress_reporter(cases: Sequence[Case], progress: Progress | None) -> Callable[[Case], None]:
    """Return a function that takes each case that has ended, and reports the progress."""
    ended: list[Case] = []
    whole = sum(case.cost for case in cases)

    def report_end(case: Case) -> None:
        ended.append(case)
        if progress is not None:
            fraction = sum(case.cost for case in ended) / whole
            progress(fraction, f"{len(ended)} of {len(cases)} cases (% of the work)")

    return report_end
