"""Ctrl-C while PETSc computes: an exception may not pass through it, so it is put off."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any


@dataclass
class Interruption:
    """Whether Ctrl-C was pressed meanwhile."""

    asked_for: bool = False


@contextmanager
def interruption_put_off() -> Iterator[Interruption]:
    """Keep Ctrl-C from raising KeyboardInterrupt until the end of the block.

    Where it is not Python's own handler that would raise it, or another thread than the first one
    computes, nothing changes.
    """
    interruption = Interruption()
    usual = signal.getsignal(signal.SIGINT)
    if usual is not signal.default_int_handler or not _is_main_thread():
        yield interruption
        return

    def note(number: int, frame: Any) -> None:
        interruption.asked_for = True

    signal.signal(signal.SIGINT, note)
    try:
        yield interruption
    finally:
        signal.signal(signal.SIGINT, usual)
    if interruption.asked_for:
        raise KeyboardInterrupt


def _is_main_thread() -> bool:
    return threading.current_thread() is threading.main_thread()
