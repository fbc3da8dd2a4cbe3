"""The variations of a study: rows of values by dotted name, from the tables of a study file.

`[vary]` is the product of its lists, `[zip]` goes through its lists side by side, `[sample]` draws
a Latin hypercube; together they make the product of the three.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

import numpy as np

from bilayer.errors import InputError
from bilayer.validation import finite, nearest, shown, whole

Row = dict[str, Any]
"""Value by dotted name, as {"cut.strips": 5, "settings.dshell.model": "morley"}."""

MOST_CASES = 10_000
"""All of them are checked before the first one is computed, which takes a few
milliseconds for each."""
DIGITS = 12
"""Significant digits of computed values: a range and a list of the same numbers are the same."""


def check_count(count: int) -> None:
    """Raise InputError if a study would have more cases than are planned at once."""
    if count > MOST_CASES:
        raise InputError(
            f"the study would have {shown(count)} cases: expected at most {MOST_CASES}, or "
            "several studies"
        )


def named_fields(table: Mapping[str, Any], before: str = "") -> dict[str, Any]:
    """Return a table of a study file by dotted names.

    To TOML, `cut.strips = [4, 5]` without quotes is a table within a table; here it is the field
    "cut.strips", as with them.
    """
    fields: dict[str, Any] = {}
    for key, value in table.items():
        if isinstance(value, Mapping) and any(
            isinstance(v, (list, Mapping)) for v in value.values()
        ):
            fields |= named_fields(value, f"{before}{key}.")  # no range: that has numbers alone
        else:
            fields[f"{before}{key}"] = value
    return fields


def product_rows(table: Mapping[str, Any]) -> list[Row]:
    """Return the product of the fields' values, the last field running fastest.

    Parameters
    ----------
    table : mapping
        For each dotted name a list of values, or {start, stop, num} for evenly spaced ones.
    """
    columns = [_values("vary", name, values) for name, values in table.items()]
    check_count(math.prod(map(len, columns)))
    return [dict(zip(table, values, strict=True)) for values in product(*columns)]


def zipped_rows(table: Mapping[str, Any]) -> list[Row]:
    """Return one row per position in lists of equal length; a single empty row for no lists."""
    if not table:
        return [{}]
    columns = {name: _values("zip", name, values) for name, values in table.items()}
    lengths = {name: len(values) for name, values in columns.items()}
    if len(set(lengths.values())) > 1:
        found = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        raise InputError(f"[zip]: expected lists of one length, but {found}")
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


def sampled_rows(table: Mapping[str, Any]) -> list[Row]:
    """Return the points of a Latin hypercube; a single empty row for an empty table.

    Parameters
    ----------
    table : mapping
        `n`, the number of points, `seed`, a whole number, and {low, high} by dotted name.
    """
    from scipy.stats import qmc  # here, for the sake of all who draw no sample: it takes 0.5 s

    if not table:
        return [{}]
    bounds = {name: value for name, value in table.items() if name not in ("n", "seed")}
    for name in ("n", "seed"):
        if name not in table:
            raise InputError(f"sample.{name}: missing, expected a whole number in table [sample]")
    count = whole("sample.n", table["n"], at_least=1, at_most=MOST_CASES)
    seed = whole("sample.seed", table["seed"], at_least=0, at_most=2**53)
    if not bounds:
        raise InputError("[sample]: expected at least one field with {low, high}")
    limits = [_limits(name, bound) for name, bound in bounds.items()]
    points = qmc.LatinHypercube(len(limits), seed=np.random.default_rng(seed)).random(count)
    scaled = qmc.scale(points, *zip(*limits, strict=True))
    return [dict(zip(bounds, map(_rounded, point), strict=True)) for point in scaled]


def _values(table: str, name: str, given: Any) -> Sequence[Any]:
    if isinstance(given, Mapping):
        return _range(f"{table}.{name}", given)
    if not isinstance(given, list) or not given:
        raise InputError(
            f"{table}.{name} = {shown(given)}: expected a list of values or {{start, stop, num}}"
        )
    for value in given:
        _check_plain(f"{table}.{name}", value)
    return given


def _check_plain(field: str, value: Any) -> None:
    """Raise InputError unless a value is a number, a text, or a list of such."""
    if isinstance(value, list):
        for part in value:
            _check_plain(field, part)
    elif not isinstance(value, (bool, int, float, str)):
        raise InputError(f"{field} = {shown(value)}: expected numbers, texts or lists of them")


def _range(field: str, given: Mapping[str, Any]) -> list[float] | list[int]:
    start, stop, num = _entries(field, given, ("start", "stop", "num"))
    count = whole(f"{field}.num", num, at_least=1, at_most=MOST_CASES)
    values = np.linspace(finite(f"{field}.start", start), finite(f"{field}.stop", stop), count)
    between_whole_numbers = isinstance(start, int) and isinstance(stop, int)
    if between_whole_numbers and np.array_equal(values, np.round(values)):
        return [int(value) for value in values]
    return [_rounded(value) for value in values]


def _limits(name: str, given: Any) -> tuple[float, float]:
    field = f"sample.{name}"
    if not isinstance(given, Mapping):
        raise InputError(f"{field} = {shown(given)}: expected {{low, high}}")
    low, high = _entries(field, given, ("low", "high"))
    if finite(f"{field}.low", low) >= finite(f"{field}.high", high):
        raise InputError(f"{field} = {{low = {low}, high = {high}}}: expected low below high")
    return low, high


def _entries(field: str, given: Mapping[str, Any], keys: Sequence[str]) -> list[Any]:
    for key in given:
        if key not in keys:
            expected = f"expected {', '.join(keys)}"
            raise InputError(f"{field}.{key}: unknown key, {expected}{nearest(key, keys)}")
    for key in keys:
        if key not in given:
            raise InputError(f"{field}.{key}: missing, expected {', '.join(keys)}")
    return [given[key] for key in keys]


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
