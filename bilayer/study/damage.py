"""Damaged files in a study's folder: each is named, set aside, and computed anew.

A file is set aside by renaming it to NAME.damaged. So none blocks a start, and nothing is lost.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

from bilayer.errors import InputError
from bilayer.runtime.terminal import Notice
from bilayer.study.case import Case
from bilayer.study.folder import StudyFolder
from bilayer.study.scalars import Scalars, read_scalars_of


def set_aside_strange(folder: StudyFolder, notice: Notice) -> None:
    """Set aside what is no regular file where the study keeps one: to open it might never end.

    Raises
    ------
    InputError
        The system does not look for such a name, for example one that is too long.
    """
    try:
        for path in folder.own_files:
            if (path.exists() or path.is_symlink()) and not path.is_file():
                notice(set_aside(path, f"study file {path}: is no regular file"))
        if (folder.cases.exists() or folder.cases.is_symlink()) and not folder.cases.is_dir():
            notice(set_aside(folder.cases, f"study file {folder.cases}: is no folder"))
    except OSError as error:
        reason = error.strerror or error
        raise InputError(f"study folder {folder.path}: cannot be made ({reason})") from error


def set_aside_plan(folder: StudyFolder, notice: Notice) -> None:
    """Set aside a plan that cannot be read; a start writes a new one."""
    if folder.plan_file.exists():
        try:
            folder.read_plan()
        except InputError as error:
            notice(set_aside(folder.plan_file, str(error)))


def set_aside_cases(folder: StudyFolder, cases: Iterable[Case], notice: Notice) -> None:
    """Set aside the damaged results and records of some cases.

    Parameters
    ----------
    folder : StudyFolder
        No process writes these cases meanwhile.
    cases : iterable of Case
        Of the plan.
    notice : callable
        Called with a line for each file that is set aside.
    """
    listed = list(cases)
    for path, reason in [*_damaged_results(folder, listed), *_damaged_records(folder, listed)]:
        notice(set_aside(path, reason))


def set_aside(path: Path, reason: str) -> str:
    """Rename a damaged file; return a line that says so."""
    number, place = 1, path.with_name(f"{path.name}.damaged")
    while place.exists() or place.is_symlink():
        number += 1
        place = path.with_name(f"{path.name}.damaged.{number}")
    path.rename(place)
    return f"{reason}; set aside as {place.name}, computed anew"


def _damaged_results(folder: StudyFolder, cases: Sequence[Case]) -> list[tuple[Path, str]]:
    """Return the results that cannot be read or are of another case, each with the reason."""
    files = [(case, folder.result_file(case.identity)) for case in cases]
    there = [(case, path) for case, path in files if path.exists() or path.is_symlink()]
    found = read_scalars_of(path for _, path in there)
    return [
        (path, reason)
        for (case, path), stored in zip(there, found, strict=True)
        if (reason := _why_not_of(case, path, stored))
    ]


def _why_not_of(case: Case, path: Path, stored: Scalars | InputError) -> str:
    """Return why a file is no result of a case; an empty text if it is one."""
    if isinstance(stored, InputError):
        return str(stored)
    identity = stored.attributes.get("study_case")
    if not isinstance(identity, str) or identity != case.identity:
        return f"result file {path}: study_case = {identity}, expected {case.identity}"
    try:
        stored.check_milestones(path, case.milestones)
    except InputError as error:
        return str(error)
    return ""


def _damaged_records(folder: StudyFolder, cases: Sequence[Case]) -> list[tuple[Path, str]]:
    """Return the records of failures that cannot be read, each with the reason."""
    damaged = []
    for case in cases:
        try:
            folder.failure(case.identity)
        except InputError as error:
            damaged.append((folder.failure_file(case.identity), str(error)))
    return damaged
