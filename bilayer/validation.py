"""Checks on single values; each names the field, the value and what was expected."""

import math
from collections.abc import Callable, Iterable, Mapping
from difflib import SequenceMatcher, get_close_matches
from numbers import Real
from typing import Any

from bilayer.errors import InputError

NEAR, VERY_NEAR = 0.6, 0.8
"""Share of letters that a name and the one suggested for it have in common, at least."""
LONGEST_NAME = 100
"""Letters of a name that are compared: the effort grows with their square."""


LARGEST, SMALLEST = 1e30, 1e-30
"""Of numbers in SI units."""
MOST = 10**9
"""Of what is counted."""
LONGEST_SHOWN = 200
"""Letters of a value in a message."""


def keep(
    instance: Any, check: Callable[..., Any], *names: str, table: str = "", **options: Any
) -> None:
    """Check fields of a frozen dataclass and keep what the check returns.

    So a number of numpy, or 5.0 for a whole number, is kept as what it stands for.

    Parameters
    ----------
    instance : frozen dataclass
        Within its `__post_init__`.
    check : callable
        One of this module's, called with the field, the value and the options.
    *names : str
        The fields.
    table : str
        What their names are written after in messages: "mesh." makes "mesh.size".
    **options
        Of the check.
    """
    for name in names:
        value = check(f"{table}{name}", getattr(instance, name), **options)
        object.__setattr__(instance, name, value)


def finite(field: str, value: Any) -> float:
    """Return `value` as a float; raise InputError unless it is a finite number.

    Beyond `LARGEST` it is none that any quantity in SI units has, and its square may have no float.
    """
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(f"{field} = {shown(value)}: expected a number")
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise InputError(f"{field} = {shown(value)}: expected a finite number")
    if abs(number) > LARGEST:
        raise InputError(f"{field} = {shown(value)}: expected a number of at most {LARGEST:g}")
    return number


def positive(field: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float; raise InputError unless it is finite and greater than zero."""
    number = finite(field, value)
    if number <= 0:
        raise InputError(f"{field} = {_quantity(value, unit)}: expected a number greater than 0")
    if number < SMALLEST:
        expected = f"expected a number of at least {SMALLEST:g}"
        raise InputError(f"{field} = {_quantity(value, unit)}: {expected}")
    return number


def within(field: str, value: Any, low: float, high: float) -> float:
    """Return `value` as a float; raise InputError unless it is a number from `low` to `high`."""
    number = finite(field, value)
    if not low <= number <= high:
        raise InputError(f"{field} = {shown(value)}: expected a number from {low:g} to {high:g}")
    return number


def not_negative(field: str, value: Any, unit: str = "") -> float:
    """Return `value` as a float; raise InputError unless it is finite and at least zero."""
    number = finite(field, value)
    if number < 0:
        raise InputError(f"{field} = {_quantity(value, unit)}: expected a number of at least 0")
    return number


def fraction(field: str, value: Any) -> float:
    """Return `value` as a float; raise InputError unless it is greater than 0 and less than 1."""
    number = positive(field, value)
    if number >= 1:
        raise InputError(f"{field} = {shown(value)}: expected a number less than 1")
    return number


def whole(field: str, value: Any, at_least: int, at_most: int = MOST) -> int:
    """Return `value` as an int; raise InputError unless it is a whole number in a range."""
    number = finite(field, value)
    if number != int(number) or number < at_least:
        raise InputError(
            f"{field} = {shown(value)}: expected a whole number of at least {at_least}"
        )
    if number > at_most:
        raise InputError(f"{field} = {shown(value)}: expected a whole number of at most {at_most}")
    return int(number)


def one_of(field: str, value: Any, choices: Iterable[str]) -> str:
    """Return `value`; raise InputError, with the nearest choice, unless it is one of `choices`."""
    known = list(choices)
    if value not in known:
        listed = ", ".join(repr(choice) for choice in known)
        expected = f"expected one of {listed}{nearest(value, known)}"
        raise InputError(f"{field} = {shown(value)}: {expected}")
    return str(value)


def listed(field: str, value: Any) -> list[Any]:
    """Return `value` as a list; raise InputError unless it is a list of something."""
    if isinstance(value, (str, bytes, Mapping)) or not isinstance(value, Iterable):
        raise InputError(f"{field} = {shown(value)}: expected a list")
    return list(value)


def text(field: str, value: Any) -> str:
    """Return `value`; raise InputError unless it is a text."""
    if not isinstance(value, str):
        raise InputError(f"{field} = {shown(value)}: expected a text")
    return str(value)


def nearest(name: Any, known: Iterable[str]) -> str:
    """Return "; did you mean 'x'?" with the known name nearest to `name`, if one is near.

    Few mistype the first letter: a name with another one has to be nearer ("gif" is no "tif").
    """
    word = str(name)[:LONGEST_NAME]
    for match in get_close_matches(word, list(known), n=3, cutoff=NEAR):
        share = SequenceMatcher(None, match, word).ratio()
        if share >= VERY_NEAR or match[:1] == word[:1]:
            return f"; did you mean {match!r}?"
    return ""


def shown(value: Any) -> str:
    """Return a value as a message shows it, if it is long its beginning alone."""
    try:
        words = str(value) if isinstance(value, Real) else repr(value)
    except (ValueError, RecursionError):  # a number of thousands of digits, a list of itself
        return f"a very long {type(value).__name__}"
    return words if len(words) <= LONGEST_SHOWN else f"{words[:LONGEST_SHOWN]}..."


def _quantity(value: Any, unit: str) -> str:
    return f"{shown(value)} {unit}".rstrip()
