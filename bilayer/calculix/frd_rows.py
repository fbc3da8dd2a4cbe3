"""The rows of numbers of a .frd file: a node's number, and three values that touch each other.

The file is made for fixed columns: ' -1', the node in 10 columns (5 in the short form) and the
values in 12 each, by C's %12.5E. A negative value of an exponent of three digits takes 13, and on
Windows every exponent has three, so from there on the columns are shifted. But each value has one
digit before its point: that says where it begins, and nothing is read by columns. Fortran, in which
older versions write, leaves out the E before three digits.
"""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError

NODE_COLUMNS = {"0": 5, "1": 10}
"""Columns of the node's number by the format in the block's header (cgx manual, "2C")."""
ROW = " -1"
_EXPONENT = r"(?:E[-+]\d{2,3}|[-+]\d{3})(?=[-+ ]|\d[.,]|$)"
_VALUE = rf"[ ]*([-+]?\d[.,]\d{{5}}{_EXPONENT}|[-+]?(?:nan|inf(?:inity)?)\b)"
THREE_VALUES = re.compile(3 * _VALUE + r"\s*", re.IGNORECASE)


def read_rows(
    lines: Sequence[str], columns: int, first_line: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Return the node numbers (k,), ascending, and the values (k, 3) of the rows of a block.

    Parameters
    ----------
    lines : sequence of str
        Of the block; those that are no rows are passed over.
    columns : int
        Of a node's number.
    first_line : int
        Number of the first one in the file, for the messages.

    Raises
    ------
    InputError
        A row is not of a node number and three values, or a node comes twice.
    """
    end = len(ROW) + columns
    numbers, values = [], []
    for count, line in enumerate(lines):
        if line.startswith(ROW):
            node, found = line[len(ROW) : end].strip(), THREE_VALUES.fullmatch(line, end)
            if not node.isdecimal() or found is None:
                raise InputError(
                    f"line {first_line + count} is {line.strip()!r}, expected a node number in "
                    f"{columns} columns and three values such as -1.23456E-03"
                )
            numbers.append(int(node))
            values.append([_value(text) for text in found.groups()])
    order = np.argsort(numbers, kind="stable")
    sorted_numbers = np.array(numbers, dtype=np.int64)[order]
    twice = np.flatnonzero(np.diff(sorted_numbers) == 0)
    if len(twice):
        raise InputError(f"node {sorted_numbers[twice[0]]} comes twice, expected each once")
    return sorted_numbers, np.array(values).reshape(-1, 3)[order]


def _value(text: str) -> float:
    """Return the number of a text that fits the pattern."""
    return float(re.sub(r"(?<=\d)([-+]\d{3})$", r"E\1", text.replace(",", ".")))
