"""SIGTERM, as at the end of a job's time on a cluster, is taken as Ctrl-C: what is done is kept."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from bilayer.runtime.ranks import has_other_ranks


@contextmanager
def termination_as_ctrl_c() -> Iterator[None]:
    """Let SIGTERM interrupt the block as Ctrl-C does.

    Among several ranks nothing changes: one that goes on alone would wait for the others for ever.
    """
    if has_other_ranks() or not may_handle_signals():
        yield
        return
    usual = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, usual)


def may_handle_signals() -> bool:
    """Whether this is the thread in which Python lets signals be handled."""
    return threading.current_thread() is threading.main_thread()
