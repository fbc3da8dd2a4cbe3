"""The cases of a study as a table for the screen: what was varied, and what came of it."""

import pandas as pd

from bilayer.results.table import cells
from bilayer.runtime.terminal import one_line

MOST_ROWS = 40
"""Cases that are shown; study.csv has all of them."""


def case_table(index: pd.DataFrame) -> str:
    """Return a line for each case: varied values, status, its last milestone, the time.

    Parameters
    ----------
    index : DataFrame
        See `bilayer.study.index.read_index`.

    Returns
    -------
    str
        At most `MOST_ROWS` lines, under one of titles, and one that says how many are left out.
    """
    shown = list(index.groupby("case", sort=False))[:MOST_ROWS]
    table = pd.DataFrame([_row(case) for _, case in shown])
    lines = [table.to_string(index=False, na_rep="-")]
    left_out = index["case"].nunique() - len(shown)
    if left_out > 0:
        lines.append(f"... and {left_out} more")
    return "\n".join(lines)


def _row(case: pd.DataFrame) -> dict[str, str]:
    """Return the cells of a case, which has a row for each of its milestones."""
    first = case.iloc[0]
    reached = case[case["converged"] == 1]
    names = list(case.columns)
    varied = names[names.index("model") + 1 : names.index("prestretch")]
    row = {"case": first["case"], "solver": f"{first['solver']} {first['model']}"}
    row |= {name: one_line(_value(first[name])) for name in varied}
    row |= {"status": first["status"], "reached": f"{len(reached)} of {len(case)}"}
    last = reached.tail(1)
    for title, name, scale, pattern in (
        ("last λ", "prestretch", 1.0, "{:g}"),
        ("quality", "quality", 1.0, "{:.3f}"),
        ("height mm", "height", 1e3, "{:.2f}"),
        ("time s", "case_seconds", 1.0, "{:.1f}"),
    ):
        row[title] = (cells(scale * last[name].astype(float), pattern) or ["-"])[0]
    return row


def _value(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
