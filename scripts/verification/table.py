"""The ladder as a table: in the terminal, and as the page docs/verification.md."""

import math
import textwrap
from collections.abc import Mapping, Sequence

from bilayer.errors import InputError
from verification.rung import MISSED, PASSED, Check, Rung

Ladder = Sequence[tuple[Rung, Sequence[Check]]]
HEADINGS = ("quantity", "measured", "reference", "error", "tolerance", "verdict")
INTRODUCTION = (
    "Cases with known answers. `scripts/verify` writes this page. It computes every number of the "
    'column "measured" anew, and fails if one misses its tolerance. Errors and tolerances are '
    "relative to the reference, or absolute if the reference is 0. A number without a tolerance is "
    "reported, not judged."
)
COLUMNS = 100
"""Of a line of text on the page."""
WIDTHS = (46, 11, 11, 9, 9, 8)


def missed(ladder: Ladder) -> int:
    """Return the number of checks that miss their tolerance."""
    return sum(check.verdict == MISSED for _, checks in ladder for check in checks)


def summary(ladder: Ladder) -> str:
    """Return one line: how many rungs and checks, and how many of these miss."""
    judged = [check for _, checks in ladder for check in checks if check.tolerance is not None]
    count = missed(ladder)
    return _summary(len(ladder), len(judged) - count, count)


def _summary(rungs: int, passed: int, missed: int) -> str:
    judged = f"{passed + missed} checks with a tolerance"
    return f"{rungs} rungs, {judged}: {passed} passed, {missed} missed."


def rung_text(rung: Rung, checks: Sequence[Check]) -> str:
    """Return a rung as lines for the terminal."""
    lines = [f"{rung.number}  {rung.title}  [{rung.solver}]", _row(HEADINGS)]
    return "\n".join(lines + [_row(_cells(check)) for check in checks]) + "\n"


def page(ladder: Ladder, absent: Mapping[str, str]) -> str:
    """Return the page of the whole ladder, with the rungs that it lacks and why."""
    return _page([_section(rung, checks) for rung, checks in ladder], absent)


def renewed_page(
    text: str, rungs: Sequence[Rung], ladder: Ladder, absent: Mapping[str, str]
) -> str:
    """Return a page on which some rungs are computed anew and the others as they were.

    Parameters
    ----------
    text : str
        The page as it was.
    rungs : sequence of Rung
        All of them, in their order.
    ladder : Ladder
        Those that are computed anew.
    absent : mapping of str to str
        As that of `page`.

    Raises
    ------
    InputError
        A rung is neither on the page nor computed.
    """
    known = {part.splitlines()[0]: part.strip() for part in text.split("\n## ")[1:]}
    known |= {_heading(rung): _section(rung, checks) for rung, checks in ladder}
    lacking = [rung for rung in rungs if _heading(rung) not in known]
    if lacking:
        raise InputError(f"rung {lacking[0].number}: is not on the page, expected it among RUNG")
    return _page([known[_heading(rung)] for rung in rungs], absent)


def _page(sections: Sequence[str], absent: Mapping[str, str]) -> str:
    verdicts = [line.split(" | ")[-1].strip(" |") for part in sections for line in _rows(part)]
    counts = [verdicts.count(verdict) for verdict in (PASSED, MISSED)]
    lacking = "\n".join(
        _filled(f"- **{name}**: {why}", indent="  ") for name, why in absent.items()
    )
    headed = [f"## {part}" for part in [*sections, f"Missing\n\n{lacking}"]]
    introduction = ["# Verification", _filled(INTRODUCTION), _summary(len(sections), *counts)]
    return "\n\n".join([*introduction, *headed]) + "\n"


def _rows(section: str) -> list[str]:
    """Return the rows of a rung's table, its head left out."""
    return [line for line in section.splitlines() if line.startswith("| ")][2:]


def _heading(rung: Rung) -> str:
    return f"{rung.number}. {rung.title} ({rung.solver})"


def _section(rung: Rung, checks: Sequence[Check]) -> str:
    """Return a rung on the page, without the sign of its heading."""
    rows = [HEADINGS, ("---",) * len(HEADINGS), *map(_cells, checks)]
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    return "\n\n".join([_heading(rung), _filled(rung.source), table])


def _filled(text: str, indent: str = "") -> str:
    return textwrap.fill(text, COLUMNS, subsequent_indent=indent, break_on_hyphens=False)


def _cells(check: Check) -> tuple[str, ...]:
    if check.note:
        return (f"{check.quantity} {check.note}", "-", "-", "-", "-", check.verdict)
    return (
        check.quantity,
        f"{check.measured:.6g}",
        *_against(check),
        "-" if check.tolerance is None else _tolerance(check.tolerance),
        check.verdict,
    )


def _against(check: Check) -> tuple[str, str]:
    """Return the reference and the error; nothing if a number stands for itself."""
    if math.isnan(check.reference):
        return "-", "-"
    error = f"{check.error:.1e}" if check.error < 1e-5 else f"{100 * check.error:.3f} %"
    return f"{check.reference:.6g}", error


def _tolerance(value: float) -> str:
    return f"{100 * value:g} %" if value >= 1e-4 else f"{value:g}"


def _row(words: Sequence[str]) -> str:
    first, *rest = (f"{word:<{width}}" for word, width in zip(words, WIDTHS, strict=True))
    numbers = (f"{word.strip():>{width}}" for word, width in zip(rest, WIDTHS[1:], strict=True))
    return "  ".join(["  " + first, *numbers])
