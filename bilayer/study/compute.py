"""One case of a study, computed and kept: its result, or the reason why there is none.

Each milestone is in the folder when it is reached. A case that was interrupted goes on from there.
"""

import time
import traceback
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.errors import InputError, MachineError, NotResumableError
from bilayer.results.files import open_result
from bilayer.runtime.machine_faults import is_of_the_machine, lacks_memory, tells_of_memory
from bilayer.runtime.output_file import remove_leftovers
from bilayer.solvers.registry import solve, solver_named
from bilayer.study.case import Case
from bilayer.study.damage import set_aside
from bilayer.study.folder import LOG_BEGUN, LOG_SET_ASIDE, StudyFolder
from bilayer.study.neighbours import Neighbours, NoNeighbours
from bilayer.study.records import CASE_FAILED, CASE_LACKS_MEMORY


def compute_case(
    case: Case,
    folder: StudyFolder,
    comm: Any = None,
    neighbours: Neighbours | None = None,
    limit: float | None = None,
) -> None:
    """Solve a case and write what came out.

    Whatever goes wrong in the solver is recorded and goes no further.

    Parameters
    ----------
    case : Case
        What to compute.
    folder : StudyFolder
        Where to keep it.
    comm : mpi4py.MPI.Comm, optional
        The ranks that share the case; all of them call, the first writes.
    neighbours : Neighbours, optional
        Earlier results of this process, one of which may start the case. Cases that turn out to
        have been started wrongly are computed again.
    limit : float, optional
        Seconds that a milestone may take.

    Raises
    ------
    MachineError
        The folder cannot be written, for example on a full disk, or a library or a compiler of the
        machine fails; the case stays to be computed.
    """
    first = comm is None or comm.Get_rank() == 0
    if not (first or solver_named(case.solver).parallel):
        return  # the first rank computes alone
    if first:
        folder.log(LOG_BEGUN, case)
    start = time.perf_counter()
    try:
        result, before = _solve(case, folder, comm, neighbours or NoNeighbours(), limit)
    except Exception as error:
        if first:
            _keep_error(case, folder, error)
        elif isinstance(error, MachineError):
            raise
        return
    if first and tells_of_memory(str(result.attrs["stop_reason"])):
        folder.keep_failure(case, result.attrs["stop_reason"], status=CASE_LACKS_MEMORY)
    elif first:
        folder.keep_result(case, result, before + time.perf_counter() - start)
    for other in [] if neighbours is None else neighbours.withdrawn():
        compute_case(other, folder, comm, limit=limit)


def _keep_error(case: Case, folder: StudyFolder, error: Exception) -> None:
    """Record what a case has failed by, or raise MachineError if the case is not to blame."""
    reason = f"{type(error).__name__}: {error}"
    if lacks_memory(error):
        folder.keep_failure(case, reason, traceback.format_exc(), CASE_LACKS_MEMORY)
    elif is_of_the_machine(error):
        folder.log_not_written(case, error)
        if isinstance(error, MachineError):
            raise error
        raise MachineError(
            f"case {case.identity} ({case}): {reason}; the machine is to be mended, the next start "
            "goes on"
        ) from error
    else:
        folder.keep_failure(case, reason, traceback.format_exc(), CASE_FAILED)


def _solve(
    case: Case,
    folder: StudyFolder,
    comm: Any,
    neighbours: Neighbours | NoNeighbours,
    limit: float | None,
) -> tuple[xr.Dataset, float]:
    """Return the result of a case, and the seconds that an earlier start spent on it.

    It goes on from the milestones of an earlier start, if they can be used.
    """
    first = comm is None or comm.Get_rank() == 0
    file = folder.unfinished_file(case.identity)
    if first:
        remove_leftovers(file)
    compute = partial(
        solve, case.specimen, case.solver, case.settings, comm=comm, output=file, limit=limit
    )
    if not file.exists():
        return neighbours.solve(case, compute), 0.0
    try:
        before = _seconds_in(file)
        return compute(resume=file), before
    except NotResumableError as error:
        reason = str(error)
    if first:
        folder.log(LOG_SET_ASIDE, case, set_aside(file, reason))
    return compute(), 0.0


def _seconds_in(file: Path) -> float:
    """Return the seconds that an earlier start spent on the milestones in its file."""
    try:
        return float(open_result(file)["wall_time"].sum())
    except InputError as error:
        raise NotResumableError(str(error)) from error
