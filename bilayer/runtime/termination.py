"""Ctrl-C and SIGTERM: the second is taken as the first, and both wait while nothing may be lost."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from types import FrameType
from typing import NoReturn

from bilayer.errors import Terminated
from bilayer.runtime.ranks import has_other_ranks

SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def termination_as_ctrl_c() -> Iterator[None]:
    """Let SIGTERM, as at the end of a job's time on a cluster, raise `Terminated` in the block.

    Among several ranks it ends the process as usual: one that goes on alone would wait for the
    others for ever.
    """
    if not may_handle_signals():
        yield
        return
    usual = signal.signal(signal.SIGTERM, _terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, usual)


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    if has_other_ranks():
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)
    raise Terminated


@dataclass
class PutOff:
    """The first signal that has come meanwhile, or None."""

    number: int | None = None

    @property
    def asked_for(self) -> bool:
        """Whether one has come."""
        return self.number is not None


@contextmanager
def signals_put_off() -> Iterator[PutOff]:
    """Keep Ctrl-C and SIGTERM from raising an exception until the end of the block.

    A signal whose handler would not raise one (ignored, or SIGTERM that ends the process) is left
    as it is; so are all in a thread other than the first. Blocks may be nested.
    """
    put_off = PutOff()

    def note(number: int, frame: FrameType | None) -> None:
        if put_off.number is None:
            put_off.number = number

    raising = [number for number in SIGNALS if callable(signal.getsignal(number))]
    usual = {}
    try:
        for number in raising if may_handle_signals() else []:
            usual[number] = signal.signal(number, note)
        yield put_off
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        if put_off.number is not None:
            signal.raise_signal(put_off.number)


def may_handle_signals() -> bool:
    """Whether this is the thread in which Python lets signals be handled."""
    return threading.current_thread() is threading.main_thread()
