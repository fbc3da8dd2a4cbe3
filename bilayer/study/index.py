"""The index of a study: a table of every case and prestretch, made from the files of its folder."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from bilayer.errors import INTERRUPTED, InputError
from bilayer.runtime.output_file import whole_file
from bilayer.solvers.registry import settings_class
from bilayer.study.folder import StudyFolder
from bilayer.study.records import CASE_DONE, CASE_FAILED, NoResult
from bilayer.study.scalars import Scalars, read_scalars_of

CASE_STOPPED, CASE_MISSING = "stopped early", "missing"
CASE_UNFINISHED = "unfinished"
"""Status of a case that has some milestones, and goes on from there when it is computed again."""
SHOWN = (
    "converged", "quality", "sphere_radius", "sphere_rmse", "hemisphere_distance", "height",
    "unstable_modes", "self_contact_gap", "load_steps", "iterations", "residual",
)  # fmt: skip
TIMINGS = ("wall_time", "case_seconds")
"""The columns that differ from run to run."""


def read_index(folder: StudyFolder) -> pd.DataFrame:
    """Return the index of a study, from its files.

    Returns
    -------
    DataFrame
        A row per case and milestone: the case's hash, solver, model, the varied values,
        `prestretch` (the larger of `prestretch_x` and `prestretch_y`), `status` (done, stopped
        early, unfinished, failed, lacks memory, died, missing), scalars of the result in SI units,
        the `reason` if something is missing, what made it, and the timings.
    """
    planned = folder.read_plan()
    kept = [folder.kept_file(entry["case"]) for entry in planned["cases"]]
    there = [file for file in kept if file.exists()]
    stored = dict(zip(there, read_scalars_of(there), strict=True))
    rows = [
        row
        for entry, file in zip(planned["cases"], kept, strict=True)
        for row in _rows(folder, entry, planned["fields"], stored.get(file))
    ]
    return pd.DataFrame(rows)


def write_index(folder: StudyFolder) -> pd.DataFrame:
    """Write `study.csv` anew; return the index.

    Raises
    ------
    ComputationError
        Writing failed, for example on a full disk; the earlier index stays.
    """
    index = read_index(folder)
    with whole_file(folder.index_file, "study index") as partial:
        index.to_csv(partial, index=False)
    return index


def _rows(
    folder: StudyFolder,
    entry: Mapping[str, Any],
    fields: list[str],
    found: Scalars | InputError | None,
) -> list[dict[str, Any]]:
    varied = {name: entry["values"].get(name) for name in fields if name != "solver"}
    named = {"case": entry["case"], "solver": entry["solver"], "model": entry["model"], **varied}
    stored, status, reason = _state(folder, entry, found)
    count = len(entry["milestones"])
    columns = {name: _column(stored, name, count) for name in (*SHOWN, "wall_time")}
    made = {} if stored is None else stored.attributes
    return [
        {
            **named,
            "prestretch": max(pair),
            "prestretch_x": pair[0],
            "prestretch_y": pair[1],
            "status": status,
            **{name: columns[name][k] for name in SHOWN},
            "reason": reason,
            "triangles": 0 if stored is None else stored.triangles,
            "versions": made.get("versions", ""),
            "git_commit": made.get("git_commit", ""),
            "wall_time": columns["wall_time"][k],
            "case_seconds": made.get("study_case_seconds", np.nan),
        }
        for k, pair in enumerate(entry["milestones"])
    ]


def _state(
    folder: StudyFolder, entry: Mapping[str, Any], stored: Scalars | InputError | None
) -> tuple[Scalars | None, str, str]:
    """Return the stored scalars of a case, its status, and the reason of the status."""
    path = folder.kept_file(entry["case"])
    try:
        failure = folder.failure(entry["case"])
        if stored is None:
            return None, *_recorded(failure, CASE_MISSING, "")
        if isinstance(stored, InputError):
            raise stored
        stored.check_milestones(path, len(entry["milestones"]))
    except InputError as error:
        return None, CASE_FAILED, str(error)
    if path == folder.unfinished_file(entry["case"]):
        return stored, *_recorded(failure, CASE_UNFINISHED, INTERRUPTED)
    reason = str(stored.attributes["stop_reason"])
    kind = settings_class(entry["solver"], entry["model"])
    ended_well = bool(np.all(stored.values["converged"] == 1)) or getattr(
        kind, "stopping_is_a_result", False
    )
    return stored, CASE_DONE if ended_well else CASE_STOPPED, reason


def _recorded(failure: NoResult | None, status: str, reason: str) -> tuple[str, str]:
    """Return status and reason as they were recorded, or these if nothing was."""
    return (status, reason) if failure is None else (failure.status, failure.reason)


def _column(stored: Scalars | None, name: str, count: int) -> Any:
    if stored is None or name not in stored.values:
        return np.full(count, np.nan)
    return stored.values[name]
