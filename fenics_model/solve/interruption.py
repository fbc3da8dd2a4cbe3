"""Ctrl-C while PETSc computes: an exception may not pass through it, so it is put off.

So is the signal that ends a job, where it is taken as Ctrl-C (`bilayer.runtime.termination`).
"""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from bilayer.runtime.termination import may_handle_signals

SIGNALS = (signal.SIGINT, signal.SIGTERM)


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

    def note(number: int, frame: Any) -> None:
        interruption.asked_for = True

    raising = [number for number in SIGNALS if _raises(number)] if may_handle_signals() else []
    for number in raising:
        signal.signal(number, note)
    try:
        yield interruption
    finally:
        for number in raising:
            signal.signal(number, signal.default_int_handler)
    if interruption.asked_for:
        raise KeyboardInterrupt


def _raises(number: int) -> bool:
    return signal.getsignal(number) is signal.default_int_handler
