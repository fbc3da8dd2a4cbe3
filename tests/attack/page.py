"""docs/reliability.md: the figures of the last runs of scripts/attack, between their marks."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

Rows = Sequence[dict[str, str]]


def write(page: Path, results: Path) -> None:
    """Write the tables of the files that there are into the page."""
    text = page.read_text(encoding="utf-8")
    for name, table in TABLES.items():
        file = results / f"{name}.csv"
        if file.exists():
            with file.open(encoding="utf-8", newline="") as rows:
                text = with_part(text, name, table(list(csv.DictReader(rows))))
    page.write_text(text, encoding="utf-8")


def with_part(text: str, name: str, table: str) -> str:
    """Return a page with a table between the marks of that name.

    Raises
    ------
    ValueError
        The marks are not there.
    """
    begin, end = (f"<!-- {edge} of scripts/attack {name} -->" for edge in ("begin", "end"))
    before, after = text[: text.index(begin)], text[text.index(end) :]
    return f"{before}{begin}\n\n{table}\n\n{after}"


def _inputs(rows: Rows) -> str:
    lines = [(r["kind"], r["inputs"], r["mishandled"], r["longest_seconds"]) for r in rows]
    count, bad = (sum(int(row[key]) for row in rows) for key in ("inputs", "mishandled"))
    longest = max(float(row["longest_seconds"]) for row in rows)
    lines.append(("all", str(count), str(bad), f"{longest:g}"))
    head = ("class", "inputs", "mishandled", "longest (s)")
    seeds = ", ".join(dict.fromkeys(row["seed"] for row in rows))
    return f"Seed {seeds}: {bad} of {count} mishandled.\n\n{_table(head, lines)}"


def _moments(rows: Rows) -> str:
    lines = [
        (r["moment"], r["signal"], r["reached"], r["kept"], r["wrong"] or "as promised")
        for r in rows
    ]
    bad = sum(bool(row["wrong"]) for row in rows)
    head = ("moment", "signal", "milestones reached", "in the file", "outcome")
    return f"{bad} of {len(rows)} mishandled.\n\n{_table(head, lines)}"


def _kills(rows: Rows) -> str:
    random = [row for row in rows if "after" in row["moment"]]
    bad = sum(bool(row["wrong"]) for row in rows)
    kept = sum(int(row["kept"]) for row in random)
    lines = [(r["moment"], r["kept"], r["wrong"] or "as promised") for r in rows]
    return (
        f"{len(rows) - len(random)} placed and {len(random)} random moments: {bad} mishandled. "
        f"At the random ones {kept} cases were finished, all of them kept.\n\n"
        + _table(("moment", "kept", "outcome"), lines)
    )


def _conditions(rows: Rows) -> str:
    lines = [(r["what"], r["outcome"], r["wrong"] or "as promised") for r in rows]
    return _table(("condition", "what came of it", "outcome"), lines)


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)


TABLES: dict[str, Callable[[Rows], str]] = {
    "inputs": _inputs,
    "signals": _moments,
    "kills": _kills,
    "conditions": _conditions,
}
"""By the name of the file in results/attack."""
