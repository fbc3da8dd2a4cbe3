"""One case of a study, computed and kept: its result, or the reason why there is none."""

import time
import traceback
from typing import Any

from bilayer.solvers.registry import solve, solver_named
from bilayer.study.case import Case
from bilayer.study.folder import BEGUN, StudyFolder


def compute_case(case: Case, folder: StudyFolder, comm: Any = None) -> None:
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

    Raises
    ------
    ComputationError
        The folder cannot be written, for example on a full disk.
    """
    first = comm is None or comm.Get_rank() == 0
    if not (first or solver_named(case.solver).parallel):
        return  # the first rank computes alone
    if first:
        folder.log(BEGUN, case)
    start = time.perf_counter()
    try:
        result = solve(case.specimen, case.solver, case.settings, comm=comm)
    except Exception as error:
        if first:
            reason = f"{type(error).__name__}: {error}"
            folder.keep_failure(case, reason, traceback.format_exc())
        return
    if first:
        folder.keep_result(case, result, time.perf_counter() - start)
