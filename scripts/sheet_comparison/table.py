"""Rows of plain values in a file of comma-separated values, a column for each field."""

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

from bilayer.runtime.output_file import whole_file

RowType = TypeVar("RowType")


def read_table(path: Path, kind: type[RowType]) -> list[RowType]:
    """Return the rows of a file, each a dataclass of that kind; none if there is no file."""
    if not path.exists():
        return []
    columns: Any = fields(kind)  # type: ignore[arg-type]
    with path.open() as file:
        return [
            kind(**{column.name: column.type(row[column.name]) for column in columns})
            for row in csv.DictReader(file)
        ]


def write_table(path: Path, rows: Sequence[Any]) -> None:
    """Write rows of one kind, at least one."""
    names = [field.name for field in fields(rows[0])]
    with whole_file(path, "table") as whole, whole.open("w", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
