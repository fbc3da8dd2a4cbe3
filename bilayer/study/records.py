"""The records in a study's folder: its plan, and why a case has no result, as JSON."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bilayer.errors import InputError
from bilayer.solvers.registry import SOLVERS
from bilayer.validation import listed, one_of, positive, text

CASE_DONE, CASE_FAILED, CASE_LACKS_MEMORY = "done", "failed", "lacks memory"
CASE_DIED = "died"
"""Status of a case; its process died, by a limit of the machine or a crash, if it is the last."""
NO_RESULT = (CASE_FAILED, CASE_LACKS_MEMORY, CASE_DIED)
IDENTITY = re.compile(r"[0-9a-f]{16}")
"""The hash of a case, which is a part of the names of its files."""
LARGEST_PLAN = 2**28
"""Bytes of a plan that are read."""


@dataclass(frozen=True)
class NoResult:
    """The reason why a case has no result.

    Parameters
    ----------
    status : {"failed", "lacks memory", "died"}
        A case that failed is left alone by later starts. For the others the machine may be to
        blame, so they are computed again.
    reason : str
        In one line.
    """

    status: str
    reason: str


def failure_from(record: str) -> NoResult:
    """Return the reason why a case has no result from the text of its record.

    Raises
    ------
    InputError
        It is none.
    """
    content = _mapping("the record", _parsed(record))
    status = one_of("status", content.get("status", CASE_FAILED), NO_RESULT)
    return NoResult(status, " ".join(text("reason", content.get("reason")).split()))


def plan_from(record: str) -> dict[str, Any]:
    """Return a plan, `fields` and `cases`, from the text of `StudyFolder.keep_plan`.

    The milestones of each case are pairs; older plans hold the larger stretch alone.

    Raises
    ------
    InputError
        It is none.
    """
    content = _mapping("the plan", _parsed(record))
    fields = [text("fields", name) for name in listed("fields", content.get("fields"))]
    entries = listed("cases", content.get("cases"))
    if not entries:
        raise InputError("cases = []: expected at least one")
    cases = [_case(number, entry) for number, entry in enumerate(entries)]
    return {"fields": fields, "cases": cases}


def _case(number: int, entry: Any) -> dict[str, Any]:
    field = f"cases[{number}]"
    content = _mapping(field, entry)
    identity = text(f"{field}.case", content.get("case"))
    if not IDENTITY.fullmatch(identity):
        raise InputError(f"{field}.case = {identity!r}: expected 16 hexadecimal digits")
    milestones = listed(f"{field}.milestones", content.get("milestones"))
    return {
        "case": identity,
        "solver": one_of(f"{field}.solver", content.get("solver"), SOLVERS),
        "model": text(f"{field}.model", content.get("model")),
        "mesh": text(f"{field}.mesh", content.get("mesh")),
        "milestones": [_pair(f"{field}.milestones", stretch) for stretch in milestones],
        "values": dict(_mapping(f"{field}.values", content.get("values"))),
    }


def _pair(field: str, stretch: Any) -> tuple[float, float]:
    pair = stretch if isinstance(stretch, list) else [stretch, stretch]
    if len(pair) != 2:
        raise InputError(f"{field}: {stretch!r}, expected a number or two")
    return positive(field, pair[0]), positive(field, pair[1])


def _mapping(field: str, content: Any) -> Mapping[str, Any]:
    if not isinstance(content, dict):
        raise InputError(f"{field} = {content!r}: expected names with values")
    return content


def _parsed(record: str) -> Any:
    try:
        return json.loads(record)
    except (ValueError, RecursionError) as error:
        raise InputError(f"not JSON ({error})") from error
