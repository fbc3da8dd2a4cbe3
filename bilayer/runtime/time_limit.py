"""A limit of time for a part of a run, which a solver looks at wherever it may stop.

The driver of a path sets it for each milestone. Whoever iterates asks whether the time is up. Ranks
that iterate together must agree on that, because their clocks differ.
"""

import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from bilayer.errors import ComputationError, InputError
from bilayer.validation import shown

UNITS = {"s": 1.0, "min": 60.0, "h": 3600.0}

_OVER = "the time limit for a milestone is over"

_end: ContextVar[float] = ContextVar("end of the time", default=float("inf"))


class TimeIsUpError(ComputationError):
    """The time that a milestone may take is over."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Let `time_is_up` be true when some seconds are over, or when those of a block around are."""
    token = _end.set(min(_end.get(), time.monotonic() + seconds))
    try:
        yield
    finally:
        _end.reset(token)


def time_is_up() -> bool:
    """Whether the time is up.

    Examples
    --------
    >>> time_is_up()
    False
    >>> with time_limit(0.0):
    ...     time_is_up()
    True
    """
    return time.monotonic() >= _end.get()


def check_time(is_up: bool | None = None) -> None:
    """Raise TimeIsUpError if the time is up.

    Parameters
    ----------
    is_up : bool, optional
        What several ranks have agreed on; asked for if left out.
    """
    if time_is_up() if is_up is None else is_up:
        raise TimeIsUpError(_OVER)


def tells_of_time(words: str) -> bool:
    """Whether the reason why a run stopped is that its time was over."""
    return _OVER in words


def read_duration(name: str, word: str) -> float:
    """Return the seconds of a text such as "5min".

    Parameters
    ----------
    name : str
        Of the field, for the message.
    word : str
        A number with one of `UNITS`; seconds without.

    Raises
    ------
    InputError
        It is none, or not positive.

    Examples
    --------
    >>> read_duration("--limit", "5min"), read_duration("--limit", "90")
    (300.0, 90.0)
    """
    found = re.fullmatch(r"\s*(\d+(?:\.\d*)?|\.\d+)\s*(s|min|h)?\s*", word)
    seconds = 0.0 if found is None else float(found[1]) * UNITS[found[2] or "s"]
    if not 0 < seconds < float("inf"):
        raise InputError(f"{name} = {shown(word)}: expected a time such as 90s, 5min or 2h")
    return seconds
