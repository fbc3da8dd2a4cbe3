"""The memory that the cases of a study take: which of them fit at all, and how many at once."""

from collections.abc import Sequence

from bilayer.errors import NotEnoughMemoryError
from bilayer.study.case import Case

Shortages = dict[Case, str]
"""The reasons of the cases that do not fit into the memory."""


def separate_by_memory(cases: Sequence[Case], available: float) -> tuple[list[Case], Shortages]:
    """Return the cases that fit into the memory, in their order, and why the others do not.

    Parameters
    ----------
    cases : sequence of Case
        To be computed.
    available : float
        Bytes that one case may take.
    """
    shortages: Shortages = {}
    for case in cases:
        try:
            case.check_memory(available)
        except NotEnoughMemoryError as error:
            shortages[case] = f"{type(error).__name__}: {error}"
    return [case for case in cases if case not in shortages], shortages


def first_at_once(cases: Sequence[Case], jobs: int, available: float) -> int:
    """Return the number of first cases to compute at once: at most `jobs`, at least one."""
    count, taken = 0, 0.0
    for case in cases[:jobs]:
        taken += case.memory
        if taken > available:
            break
        count += 1
    return max(count, min(1, len(cases)))


def memory_note(cases: Sequence[Case], jobs: int, available: float) -> str:
    """Return a line that says that fewer cases are computed at once than asked for, or none."""
    count, wanted = first_at_once(cases, jobs, available), min(jobs, len(cases))
    if count == wanted:
        return ""
    return (
        f"{count} instead of {wanted} cases at a time: the {available / 2**30:.3g} GiB of memory "
        f"available hold no more of the first ones ({cases[0].memory / 2**30:.3g} GiB the largest)"
    )
