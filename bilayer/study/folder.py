"""The folder of a study: what is kept of it on the disk, and what that says of each case.

plan.json             the cases of the last start, with the values that vary
cases/HASH.nc         a finished case; whole, because it is moved there when it is complete
cases/HASH.failed     why a case has no result, as JSON
cases/HASH.unfinished.nc   the milestones so far of a case that is computed, or was interrupted
study.log             a line for every case begun and ended, by any process
study.csv             the index, made anew from the files above
"""

import json
import os
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.errors import ComputationError, InputError
from bilayer.results.files import check_result_output, open_resume_point, write_result
from bilayer.runtime.input_file import read_text
from bilayer.runtime.output_file import check_writable, remove_leftovers, whole_file
from bilayer.runtime.system import hold_lock, lock_alone, lock_shared
from bilayer.runtime.terminal import tell
from bilayer.runtime.time_limit import tells_of_time
from bilayer.study.case import Case
from bilayer.study.plan import StudyPlan
from bilayer.study.records import (
    CASE_DIED,
    CASE_FAILED,
    LARGEST_PLAN,
    NoResult,
    failure_from,
    plan_from,
)

LOG_BEGUN, LOG_DONE, LOG_NOT_WRITTEN = "begun", "done", "not written"
LOG_SET_ASIDE = "set aside"
"""Events in the log, beside the status of a case that has no result."""
UNFINISHED = (LOG_BEGUN, CASE_DIED)
"""Events, if they are the last ones, of cases that may bring a run down."""


LOCK, WORKERS = ".lock", ".workers"
"""Files that are locked by the process of a study, and by those that compute its cases."""
LEFT_BY_A_WRITER = re.compile(r"\.[0-9a-f]{16}(\.unfinished)?\.[a-z0-9_]{8}")
"""Names of the folders in which the files of cases are written before they are moved."""


class StudyFolder:
    """The files of a study.

    Parameters
    ----------
    path : path-like
        The folder, made by `make`.
    """

    def __init__(self, path: str | Path) -> None:
        if not os.fspath(path):
            raise InputError("study folder '': expected a name")
        self.path = Path(path)

    @property
    def plan_file(self) -> Path:
        """The cases of the last start."""
        return self.path / "plan.json"

    @property
    def cases(self) -> Path:
        """The folder of the files of all cases."""
        return self.path / "cases"

    @property
    def index_file(self) -> Path:
        """The index, a table."""
        return self.path / "study.csv"

    @property
    def log_file(self) -> Path:
        """The log: a line for each start and each end of a case."""
        return self.path / "study.log"

    @property
    def own_files(self) -> tuple[Path, ...]:
        """The files beside those of the cases, which may not be there yet."""
        locks = (self.path / name for name in (LOCK, WORKERS))
        return (self.plan_file, self.index_file, self.log_file, *locks)

    def result_file(self, identity: str) -> Path:
        """Return the path of the result of a case."""
        return self.cases / f"{identity}.nc"

    def unfinished_file(self, identity: str) -> Path:
        """Return the path of the milestones of a case until it is finished."""
        return self.cases / f"{identity}.unfinished.nc"

    def kept_file(self, identity: str) -> Path:
        """Return the path of a case: of its result, or else of its milestones so far."""
        result, unfinished = self.result_file(identity), self.unfinished_file(identity)
        return unfinished if unfinished.exists() and not result.exists() else result

    def failure_file(self, identity: str) -> Path:
        """Return the path of the reason why a case has no result."""
        return self.cases / f"{identity}.failed"

    def make(self) -> None:
        """Make the folder, unless it is there.

        Raises
        ------
        InputError
            It cannot be made or written.
        """
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            self.cases.mkdir(exist_ok=True)
        except (OSError, ValueError) as error:
            reason = error.strerror if isinstance(error, OSError) else error
            raise InputError(f"study folder {self.path}: cannot be made ({reason})") from error
        for file in (self.plan_file, self.index_file, self.log_file):
            check_writable(file)
        check_result_output(self.result_file("trial"))

    def remove_leftovers(self) -> None:
        """Remove what processes left that were killed while they wrote; none writes now."""
        for file in (self.plan_file, self.index_file):
            remove_leftovers(file)
        for left in self.cases.iterdir():
            if LEFT_BY_A_WRITER.fullmatch(left.name) and left.is_dir():
                shutil.rmtree(left, ignore_errors=True)
        for unfinished in self.cases.glob("*.unfinished.nc"):
            if self.has_result(unfinished.name.partition(".")[0]):
                self._remove_unless_resumable(unfinished)

    def keep_plan(self, plan: StudyPlan) -> None:
        """Write the plan: what the index and the dataset are made by.

        Raises
        ------
        ComputationError
            Writing failed, for example on a full disk.
        """
        entries = [
            {
                "case": case.identity,
                "solver": case.solver,
                "model": case.model,
                "mesh": case.mesh_identity,
                "milestones": case.specimen.prestretch.milestones,
                "values": dict(case.values),
            }
            for case in plan.cases
        ]
        with whole_file(self.plan_file, "study plan") as partial:
            text = json.dumps({"fields": plan.fields, "cases": entries}, indent=1)
            partial.write_text(text, encoding="utf-8")

    def read_plan(self) -> dict[str, Any]:
        """Return the plan of `keep_plan`: `fields` and `cases`, whose milestones are pairs.

        Raises
        ------
        InputError
            There is no study in this folder, or its plan is damaged.
        """
        try:
            self.plan_file.stat()
        except OSError as error:
            raise InputError(
                f"study folder {self.path}: has no plan.json ({error.strerror}), expected the "
                "folder of `bilayer study`"
            ) from error
        with _named("study plan", self.plan_file):
            return plan_from(read_text(self.plan_file, "study plan", largest=LARGEST_PLAN))

    def has_result(self, identity: str) -> bool:
        """Whether a case is finished, be it that it stopped early."""
        return self.result_file(identity).exists()

    def log(self, event: str, case: Case, note: str = "") -> None:
        """Add a line to the log, whichever process this is.

        Raises
        ------
        ComputationError
            It cannot be written, for example on a full disk.
        """
        now = datetime.now(UTC).isoformat(timespec="milliseconds")
        words = [now, event, case.identity, f"process {os.getpid()}", str(case), note]
        line = "\t".join(words).rstrip() + "\n"
        try:
            with self.log_file.open("a", encoding="utf-8") as log:
                log.write(line)
        except OSError as error:
            raise ComputationError(
                f"study log {self.log_file}: cannot be written ({error.strerror})"
            ) from error

    def begun_without_end(self) -> set[str]:
        """Return the cases that some process began and did not end: it was killed, or crashed."""
        last_event: dict[str, str] = {}
        for line in self._log_lines():
            words = line.split("\t")
            if len(words) > 2:
                last_event[words[2]] = words[1]
        return {identity for identity, event in last_event.items() if event in UNFINISHED}

    def _log_lines(self) -> list[str]:
        """Return the lines of the log, none if it cannot be read."""
        try:
            return read_text(self.log_file, "study log", encoding="latin-1").splitlines()
        except InputError:
            return []

    def keep_result(self, case: Case, result: xr.Dataset, seconds: float) -> None:
        """Write the result of a case, whole or not at all, and log it.

        Raises
        ------
        ComputationError
            Writing failed, for example on a full disk; the case stays to be computed.
        """
        result.attrs |= {"study_case": case.identity, "study_case_seconds": seconds}
        try:
            write_result(result, self.result_file(case.identity))
        except (ComputationError, InputError) as error:
            self.log_not_written(case, error)
            raise
        self.failure_file(case.identity).unlink(missing_ok=True)
        if not tells_of_time(result.attrs["stop_reason"]):  # such a case goes on from there
            self.unfinished_file(case.identity).unlink(missing_ok=True)
        self.remove_half_written(case)
        self.log(LOG_DONE, case, f"{seconds:.2f} s {result.attrs['stop_reason']}")

    @staticmethod
    def _remove_unless_resumable(file: Path) -> None:
        """Remove the milestones of a finished case; those of one without time are needed again."""
        try:
            is_needed = file.exists() and open_resume_point(file) is not None
        except InputError:
            is_needed = False
        if not is_needed:
            file.unlink(missing_ok=True)

    def remove_half_written(self, case: Case) -> None:
        """Remove what a process that was killed while it wrote a file of a case has left."""
        for left in self.cases.glob(f".{case.identity}.*"):
            shutil.rmtree(left, ignore_errors=True)

    def log_not_written(self, case: Case, error: Exception) -> None:
        """Log that a case could not be kept, if the log can be written."""
        with suppress(ComputationError):
            self.log(LOG_NOT_WRITTEN, case, str(error))

    def keep_failure(
        self, case: Case, reason: str, trace: str = "", status: str = CASE_FAILED
    ) -> None:
        """Record why a case has no result, and log it.

        Parameters
        ----------
        case : Case
            Which one.
        reason : str
            What is shown of it, in one line.
        trace : str
            Where in the program it was, for those who look for a fault there.
        status : {"failed", "lacks memory", "died"}
            Whether later starts leave the case alone, see `NoResult`.

        Raises
        ------
        ComputationError
            Writing failed, for example on a full disk.
        """
        record = {"status": status, "reason": " ".join(reason.split()), "trace": trace}
        with whole_file(self.failure_file(case.identity), "failure record") as partial:
            partial.write_text(json.dumps(record, indent=1), encoding="utf-8")
        self.log(status, case, record["reason"])

    def failure(self, identity: str) -> NoResult | None:
        """Return the reason why a case has no result, if it was recorded.

        Raises
        ------
        InputError
            The record is damaged.
        """
        file = self.failure_file(identity)
        if not (file.exists() or file.is_symlink()):
            return None
        with _named("failure record", file):
            return failure_from(read_text(file, "failure record"))

    def has_failed(self, identity: str) -> bool:
        """Whether a case has failed for good: it is computed again only if that is asked for.

        A damaged record says nothing.
        """
        try:
            recorded = self.failure(identity)
        except InputError:
            return False
        return recorded is not None and recorded.status == CASE_FAILED

    @contextmanager
    def lock_for_study(self) -> Iterator[None]:
        """Hold the folder for one study at a time; wait for what a killed one left running.

        Raises
        ------
        ComputationError
            Another study is running in the folder.
        """
        with hold_lock(self.path / LOCK, lock_alone) as held:
            if not held:
                raise ComputationError(
                    f"study folder {self.path}: another study is running in it; end that one, "
                    "or wait for it"
                )
            self._wait_for_workers()
            yield

    @contextmanager
    def mark_as_working(self) -> Iterator[None]:
        """Mark this process, for as long as it lives, as one that writes into the folder."""
        with hold_lock(self.path / WORKERS, lock_shared):
            yield

    def _wait_for_workers(self) -> None:
        told = False
        while True:
            with hold_lock(self.path / WORKERS, lock_alone) as free:
                if free:
                    return
            if not told:
                tell("bilayer: waiting for processes of an earlier start that still compute")
                told = True
            time.sleep(0.2)


@contextmanager
def _named(what: str, file: Path) -> Iterator[None]:
    """Say of an InputError which file it is about, unless it says so."""
    try:
        yield
    except InputError as error:
        if str(file) in str(error):
            raise
        raise InputError(f"{what} {file}: {error}") from error
