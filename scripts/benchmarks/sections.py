"""CPU time by section of a program: of the functions that make each section up."""

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from functools import wraps
from typing import Any
from unittest.mock import patch

Function = tuple[Any, str]
"""A module or class, and the name of one of its functions."""


@contextmanager
def cpu_by_section(sections: Mapping[str, Sequence[Function]]) -> Iterator[dict[str, float]]:
    """Give the seconds of CPU that each section's functions take until the end of the block.

    A function that another timed one calls counts as a part of that one.
    """
    clock = _Clock(dict.fromkeys(sections, 0.0))
    with ExitStack() as stack:
        for section, functions in sections.items():
            for owner, name in functions:
                timed = clock.timed(section, getattr(owner, name))
                stack.enter_context(patch.object(owner, name, timed))
        yield clock.seconds


class _Clock:
    def __init__(self, seconds: dict[str, float]) -> None:
        self.seconds = seconds
        self._is_running = False

    def timed(self, section: str, function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(*args: Any, **options: Any) -> Any:
            if self._is_running:
                return function(*args, **options)
            self._is_running = True
            begin = time.process_time()
            try:
                return function(*args, **options)
            finally:
                self.seconds[section] += time.process_time() - begin
                self._is_running = False

        return call


def least_cpu(function: Callable[[], Any], repeats: int) -> float:
    """Return the least CPU time of some calls, s: other programs can only add to it."""
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        function()
        times.append(time.process_time() - begin)
    return min(times)
