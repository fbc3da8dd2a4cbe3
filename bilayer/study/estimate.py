"""Estimate of the work that a study still has to do: cases, time, memory."""

from collections.abc import Iterable
from dataclasses import dataclass
from datetime import timedelta

import numpy as np
import pandas as pd

from bilayer.study.case import Case
from bilayer.study.records import CASE_DONE


@dataclass(frozen=True)
class Estimate:
    """The expected work of a study.

    Parameters
    ----------
    cases : int
        Number of cases to compute.
    seconds : float
        Of computing on one process; NaN if no case of some solver and model is finished yet.
    longest : float
        Seconds of the longest case: no number of processes makes it shorter.
    measured : int
        Number of finished cases that the time is estimated from.
    memory : float
        Bytes that the largest case takes.
    """

    cases: int
    seconds: float
    longest: float
    measured: int
    memory: float


def estimate(cases: Iterable[Case], index: pd.DataFrame | None) -> Estimate:
    """Estimate what some cases take, from the finished ones of the same solver and model.

    Parameters
    ----------
    cases : iterable of Case
        Those to be computed.
    index : DataFrame or None
        The study's index, if there is one.
    """
    waiting = list(cases)
    finished = _finished(index)
    measured = finished.groupby(["solver", "model"])[["case_seconds", "work"]].sum()
    rates = measured["case_seconds"] / measured["work"]
    times = [
        rates.get((case.solver, case.model), np.nan) * case.triangles * case.milestones
        for case in waiting
    ]
    return Estimate(
        cases=len(waiting),
        seconds=float(np.sum(times)),
        longest=float(np.max(times, initial=0.0)),
        measured=len(finished),
        memory=max((case.memory for case in waiting), default=0.0),
    )


def estimate_text(expected: Estimate, processes: int) -> str:
    """Return an estimate in a few words, for a number of cases computed at a time."""
    if expected.cases == 0:
        return "nothing to compute"
    memory = (
        f"memory about {expected.memory / 2**20:.0f} MiB for the largest case, "
        f"{min(processes, expected.cases)} at a time"
    )
    if np.isnan(expected.seconds):
        return f"{expected.cases} cases to compute; time unknown, none like them finished; {memory}"
    wall = max(expected.seconds / processes, expected.longest)
    return (
        f"{expected.cases} cases to compute; time about {timedelta(seconds=max(round(wall), 1))}, "
        f"from {expected.measured} finished cases; {memory}"
    )


def _finished(index: pd.DataFrame | None) -> pd.DataFrame:
    """Return the finished cases, with their `work`: triangles times milestones."""
    columns = ["case", "solver", "model", "triangles", "status", "case_seconds"]
    rows = pd.DataFrame(columns=columns) if index is None else index[columns]
    milestones = rows.groupby("case")["case"].transform("size")
    rows = rows.assign(work=rows["triangles"] * milestones)
    return rows[rows["status"] == CASE_DONE].drop_duplicates("case")
