"""Measured stretches and stresses, read from a table of a testing machine."""

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text
from bilayer.specimen.materials.stability import LOADINGS
from bilayer.specimen.units import in_si
from bilayer.validation import nearest, one_of

MOST_BYTES = 100_000_000
STRETCH_WORDS = (r"stretch(?!ed)", r"\blambda\b", "λ")
STRAIN_WORDS = (r"strain", r"\bepsilon\b", "ε")
STRESS_WORDS = (r"stress", r"\bsigma\b", "σ")
TRUE_WORDS = (r"true", r"cauchy")
KIND_WORDS = (*TRUE_WORDS, r"nominal", r"eng", r"first", r"piola", r"^\s*-?1?\s*$")
"""What brackets in a name may hold instead of a unit."""


@dataclass(frozen=True)
class Measurement:
    """One test of a material.

    Parameters
    ----------
    name : str
        Of the file.
    loading : {"uniaxial", "equibiaxial", "planar"}
        How the sample was loaded.
    stretch : ndarray, shape (n,)
        Along the loading.
    stress : ndarray, shape (n,)
        Nominal stress: force over the area before the test, Pa.

    Examples
    --------
    >>> import bilayer, numpy as np
    >>> test = bilayer.Measurement("a", "uniaxial", np.array([1.0, 1.5]), np.array([0.0, 3e4]))
    >>> test.up_to(1.2).stretch
    array([1.])
    """

    name: str
    loading: str
    stretch: NDArray[np.float64]
    stress: NDArray[np.float64]

    def __post_init__(self) -> None:
        one_of("loading", self.loading, LOADINGS)
        if len(self.stretch) != len(self.stress):
            raise InputError(
                f"{self.name}: has {len(self.stretch)} stretches and {len(self.stress)} stresses"
            )
        values = np.concatenate([self.stretch, self.stress])
        if not np.isfinite(values).all():
            raise InputError(f"{self.name}: expected finite numbers")
        if not (self.stretch > 0).all():
            raise InputError(
                f"{self.name}: stretch = {self.stretch.min():g}: expected above 0; a column of "
                "strains has 'strain' or '%' in its name"
            )

    def up_to(self, largest: float) -> "Measurement":
        """Return the part of it up to a stretch."""
        within = self.stretch <= largest
        return replace(self, stretch=self.stretch[within], stress=self.stress[within])


def read_measurement(
    path: str | Path,
    loading: str = "uniaxial",
    stretch_column: str | None = None,
    stress_column: str | None = None,
) -> Measurement:
    r"""Read a table of stretches and stresses.

    Parameters
    ----------
    path : path-like
        Text with a line of names over columns of numbers, separated by commas, semicolons, tabs or
        spaces; lines that begin with # are left out.
    loading : {"uniaxial", "equibiaxial", "planar"}
        How the sample was loaded.
    stretch_column, stress_column : str, optional
        Names of the columns. Left out: those with "stretch" or "strain", and "stress", in their
        names. A strain is nominal (in % if its name says so), a stress nominal unless the name says
        "true". The unit of a stress stands at the end of the name: stress_kPa, stress (MPa);
        Pa without one.

    Raises
    ------
    InputError
        The file cannot be read, or a column is not found.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> file = pathlib.Path(tempfile.mkdtemp()) / "test.csv"
    >>> _ = file.write_text("strain (%),stress (kPa)\n0,0\n10,12\n20,18\n")
    >>> bilayer.read_measurement(file).stretch
    array([1. , 1.1, 1.2])
    """
    source = Path(path)
    names, table = read_table(source)
    stretch_name = chosen_column(
        source, names, stretch_column, (*STRETCH_WORDS, *STRAIN_WORDS), "stretch"
    )
    stress_name = chosen_column(source, names, stress_column, STRESS_WORDS, "stress")
    stretch = table[:, names.index(stretch_name)]
    in_percent = re.search(r"%|percent", stretch_name) is not None
    if _matches(stretch_name, STRAIN_WORDS):
        stretch = 1 + stretch / (100 if in_percent else 1)
    elif in_percent and not _matches(stretch_name, STRETCH_WORDS):
        stretch = 1 + stretch / 100  # a strain in another language
    stress = table[:, names.index(stress_name)] * unit_of_stress(stress_name)
    if _matches(stress_name, TRUE_WORDS):
        stress = stress / stretch  # the volume is kept: the area shrinks by the stretch
    return Measurement(source.name, loading, stretch, stress)


def read_table(path: Path) -> tuple[list[str], NDArray[np.float64]]:
    """Return the names of the columns, and the numbers, shape (rows, columns)."""
    text = read_text(path, "table", largest=MOST_BYTES)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    separator = _separator(lines[0]) if lines else ","
    if separator == " ":
        rows = [line.split() for line in lines]
    else:
        rows = list(csv.reader(io.StringIO("\n".join(lines)), delimiter=separator))
    if len(rows) < 2:
        raise InputError(f"{path}: expected a line of names and lines of numbers")
    names = [name.strip() for name in rows[0]]
    numbers = [_numbers(path, k, row, len(names), separator) for k, row in enumerate(rows[1:], 1)]
    return names, np.array(numbers)


def _separator(line: str) -> str:
    return next((mark for mark in ("\t", ";", ",") if mark in line), " ")


def _numbers(path: Path, line: int, row: list[str], count: int, separator: str) -> list[float]:
    values = [value.strip() for value in row]
    if separator != ",":
        values = [value.replace(",", ".") for value in values]  # a decimal comma
    try:
        numbers = [float(value) for value in values]
    except ValueError:
        numbers = []
    if len(numbers) != count:
        raise InputError(
            f"{path}: line {line} of numbers = {row}: expected {count} numbers, below one line of "
            "names"
        )
    return numbers


def chosen_column(
    path: Path, names: Sequence[str], asked: str | None, words: Sequence[str], what: str
) -> str:
    """Return the name of the column that is asked for, or else of the one that has a word."""
    if asked is not None:
        if asked not in names:
            expected = f"expected one of {', '.join(names)}"
            raise InputError(
                f"{path}: column {asked!r} is not there, {expected}{nearest(asked, names)}"
            )
        return asked
    for word in words:
        found = [name for name in names if _matches(name, (word,))]
        if len(found) == 1:
            return found[0]
        if found:
            raise InputError(
                f"{path}: {' and '.join(found)} may both be the {what}, expected "
                f"--{what}-column NAME"
            )
    listed = ", ".join(names)
    raise InputError(
        f"{path}: no column of {listed} is a {what} by its name, expected --{what}-column NAME"
    )


def _matches(name: str, words: Sequence[str]) -> bool:
    return any(re.search(word, name.replace("_", " "), re.IGNORECASE) for word in words)


def unit_of_stress(name: str) -> float:
    """Return the unit at the end of a stress' name, Pa."""
    unit = re.search(r"(?:[_\s(\[/]|^)([kMG]?Pa|psi|bar|N/mm(?:\^?2|²))[)\]]?\s*$", name)
    if unit is None:
        other = re.search(r"[(\[]([^)\]]*)[)\]]\s*$", name)
        if other is not None and not _matches(other[1], KIND_WORDS):
            raise InputError(
                f"column {name!r}: the unit {other[1]!r}, expected Pa, kPa, MPa, GPa, psi, bar or "
                "N/mm^2"
            )
        return 1.0
    written = unit[1].replace("²", "^2")
    return float(in_si("stress", {"unit": f"1 {written}"}, {"unit": "Pa"})["unit"])
