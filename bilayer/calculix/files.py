"""The files that CalculiX writes: deck.frd (shapes), deck.sta (increments), deck.cvg (iterations).

The rows of numbers in a .frd file are read by `bilayer.calculix.frd_rows`. Other programs than
CalculiX' authors built write a decimal comma, or exponents of three digits (Windows).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bilayer.calculix.frd_rows import NODE_COLUMNS, read_rows
from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text

Array = NDArray[np.float64]

LARGEST_FILE = 2**31
"""Bytes of a file of CalculiX that are read."""
VERSION = "    1UVERSION"
NODES, DISPLACEMENT, BLOCK_END, FILE_END = "    2C", " -4  DISP", " -3", " 9999"


@dataclass(frozen=True, eq=False)
class Frd:
    """The nodes of a .frd file and the last displacements in it.

    Parameters
    ----------
    points : (k, 3) array of float
        Coordinates by ascending node number, in the deck's unit.
    displacements : (k, 3) array of float
        Of the same nodes; NaN if the file holds none.
    version : str
        Of CalculiX.
    is_whole : bool
        Whether the file has its end mark, which CalculiX writes after a step that it finished.
    """

    points: Array
    displacements: Array
    version: str
    is_whole: bool


@dataclass(frozen=True)
class RunRecord:
    """Increments, iterations and residual of a run of one step.

    Parameters
    ----------
    reached : float
        Step time after the last increment that converged, of 1.
    increments : int
        Number of increments that converged.
    failed_increment : int or None
        Number of the one at which the program gave up.
    iterations : int
        Newton iterations in all, those of failed attempts included.
    residual : float
        Largest residual force after the last iteration, relative to the average force.
    """

    reached: float
    increments: int
    failed_increment: int | None
    iterations: int
    residual: float


def read_frd(path: str | Path) -> Frd:
    """Read a result file in the ASCII format (.frd).

    Raises
    ------
    InputError
        The file is missing, is binary or none of CalculiX's, or ends within its numbers.
    """
    lines = _lines(path)
    starts = [index for index, line in enumerate(lines) if line.startswith(NODES)]
    if not starts:
        raise InputError(f"frd file {path}: holds no nodes, expected a result of CalculiX")
    columns = _node_columns(path, lines[starts[0]])
    numbers, points = _block(path, lines, starts[0], columns)
    _check_nodes(path, numbers, points)
    displacements = np.full_like(points, np.nan)
    fields = [index for index, line in enumerate(lines) if line.startswith(DISPLACEMENT)]
    if fields:
        found, values = _block(path, lines, fields[-1], columns)
        if not np.array_equal(found, numbers):
            raise InputError(
                f"frd file {path}: displacements of {len(found)} nodes, expected those of all "
                f"{len(numbers)}"
            )
        displacements = values
    versions = [line[len(VERSION) :].split() for line in lines if line.startswith(VERSION)]
    version = versions[0][-1] if versions and versions[0] else ""
    return Frd(points, displacements, version, lines[-1].startswith(FILE_END))


def _check_nodes(path: str | Path, numbers: NDArray[np.int64], points: Array) -> None:
    """Raise InputError unless there are nodes, all of them somewhere."""
    if len(numbers) == 0:
        raise InputError(f"frd file {path}: holds no nodes, expected a result of CalculiX")
    nowhere = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if len(nowhere):
        first = nowhere[0]
        raise InputError(
            f"frd file {path}: node {numbers[first]} lies at {points[first]}, expected finite "
            "numbers"
        )


def _block(
    path: str | Path, lines: Sequence[str], start: int, columns: int
) -> tuple[NDArray[np.int64], Array]:
    """Return node numbers and three values each of the block that begins at a line."""
    end = next((k for k in range(start, len(lines)) if lines[k].startswith(BLOCK_END)), None)
    if end is None:
        raise InputError(
            f"frd file {path}: ends at line {len(lines)}, within its numbers: cut off?"
        )
    try:
        return read_rows(lines[start + 1 : end], columns, start + 2)
    except InputError as error:
        raise InputError(f"frd file {path}: {error}") from error


def _node_columns(path: str | Path, header: str) -> int:
    """Return the width of the node numbers that the header of the nodes tells."""
    kind = header[len(NODES) :].split()[1:2] or ["1"]
    if kind[0] not in NODE_COLUMNS:
        raise InputError(
            f"frd file {path}: its numbers are binary (format {kind[0]}), expected a text file: "
            "*NODE FILE instead of *NODE OUTPUT in the deck"
        )
    return NODE_COLUMNS[kind[0]]


def read_run_record(path: str | Path) -> RunRecord:
    """Read the .sta and .cvg files beside a .frd file.

    The attempt of an increment that failed is marked by a U, and repeated with a shorter one.

    Raises
    ------
    InputError
        One is missing, or is none of CalculiX's.
    """
    status, iterations = Path(path).with_suffix(".sta"), Path(path).with_suffix(".cvg")
    increments = list(_rows(status, columns=7))
    steps = list(_rows(iterations, columns=9))
    converged = [row for row in increments if not row[2].endswith("U")]
    gave_up = [row for row in increments[-1:] if row not in converged]
    try:
        return RunRecord(
            float(converged[-1][5]) if converged else 0.0,
            len(converged),
            int(gave_up[0][1]) if gave_up else None,
            len(steps),
            float(steps[-1][5]) / 100 if steps else np.nan,  # given in per cent
        )
    except ValueError as error:
        raise InputError(f"{status}, {iterations}: not CalculiX's ({error})") from error


def _rows(path: Path, columns: int) -> Iterator[list[str]]:
    """Yield the lines of a table that begin with a number."""
    for line in _lines(path):
        words = line.split()
        if words and words[0].isdigit():
            if len(words) != columns:
                raise InputError(
                    f"{path}: a line of {len(words)} columns ({line.strip()!r}), expected {columns}"
                )
            yield [word.replace(",", ".") for word in words]


def _lines(path: str | Path) -> list[str]:
    try:
        text = read_text(path, "file", encoding="latin-1", largest=LARGEST_FILE)
    except InputError as error:
        raise InputError(
            f"{error}, expected CalculiX's .frd file with the .sta and .cvg files beside it"
        ) from error
    lines = text.splitlines()
    if not lines:
        raise InputError(f"{path}: is empty, expected what CalculiX wrote")
    return lines
