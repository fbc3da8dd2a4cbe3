"""Work in a child process: whatever it meets there, this process goes on.

A file of unknown origin may crash the compiled library that reads it, keep it busy for ever, or
make it take all memory. The child is a copy of this process (a fork), so it starts within
milliseconds; it hands back what it found. Where the system has no fork the work is done in this
process.
"""

import faulthandler
import gc
import os
import pickle
import select
import signal
import sys
import time
import warnings
from collections.abc import Callable, Generator, Iterable, Iterator
from contextlib import closing, contextmanager
from typing import Any, NoReturn, TypeVar

import psutil

Outcome = TypeVar("Outcome")

LENGTH = 8
"""Bytes in which the length of each outcome stands before it."""
CHUNK = 2**20
_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class ChildProcessDiedError(Exception):
    """The child ended without an outcome; the text says how."""


def run_in_child(action: Callable[[], Outcome], seconds: float, memory: int) -> Outcome:
    """Return what an action returns in a child process; raise what it raises there.

    Parameters
    ----------
    action : callable
        Whatever it changes is lost, but for what it returns, which can be pickled.
    seconds : float
        Time after which the child is ended.
    memory : int
        Bytes that it may take beyond those of this process.

    Raises
    ------
    ChildProcessDiedError
        A signal ended the child, or its time was over.

    Examples
    --------
    >>> run_in_child(lambda: 2 + 2, seconds=10.0, memory=2**30)
    4
    """
    with closing(outcomes_of_child(lambda: [action()], seconds, memory)) as outcomes:
        return next(outcomes)


def outcomes_of_child(
    action: Callable[[], Iterable[Outcome]], seconds: float, memory: int
) -> Generator[Outcome, None, None]:
    """Yield one by one what an action yields in a child process; see `run_in_child`.

    Parameters
    ----------
    action : callable
        Returns an iterable.
    seconds : float
        Time for each outcome.
    memory : int
        As for `run_in_child`.
    """
    if not hasattr(os, "fork"):
        yield from action()
        return
    reader, writer = os.pipe()
    child = _fork(lambda: _hand_over(action, writer, seconds, memory))
    os.close(writer)
    pipe = _Pipe(reader)
    try:
        while (packed := pipe.take(seconds)) is not None:
            has_failed, value = pickle.loads(packed)  # written by our own child
            if has_failed:
                raise value
            yield value
        _, status = os.waitpid(child, 0)
        child = 0
        if status != 0:
            raise ChildProcessDiedError(_ending(status))
    finally:
        os.close(reader)
        if child:
            os.kill(child, signal.SIGKILL)
            os.waitpid(child, 0)


def _ending(status: int) -> str:
    if os.WIFSIGNALED(status):
        name = signal.Signals(os.WTERMSIG(status)).name
        outside = " from outside, as where memory is short" if name == "SIGKILL" else ""
        return f"is ended by the signal {name}{outside}"
    return f"ends with the status {os.waitstatus_to_exitcode(status)}"


def _fork(answer: Callable[[], NoReturn]) -> int:
    """Start the child; no signal reaches it before it has put its handlers in order."""
    with _blocked_signals() as unblock, warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of a fork beside threads
        child = os.fork()
        if child == 0:
            try:
                signal.signal(signal.SIGINT, signal.SIG_IGN)  # this process ends it if need be
                signal.signal(signal.SIGTERM, signal.SIG_DFL)
                unblock()
                answer()
            finally:
                os._exit(1)
    return child


@contextmanager
def _blocked_signals() -> Iterator[Callable[[], Any]]:
    before = signal.pthread_sigmask(signal.SIG_BLOCK, _SIGNALS)

    def unblock() -> None:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)

    try:
        yield unblock
    finally:
        unblock()


def _hand_over(
    action: Callable[[], Iterable[Any]], writer: int, seconds: float, memory: int
) -> NoReturn:
    """Do the work in the child, write its outcomes, and end without any cleaning up."""
    gc.disable()  # what belongs to the first process is not to be closed here
    faulthandler.disable()
    _limit(memory)
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)  # libraries speak as they crash
    with os.fdopen(writer, "wb") as pipe:
        try:
            _set_alarm(seconds)
            for outcome in action():
                _write(pipe, pickle.dumps((False, outcome), protocol=5))
                _set_alarm(seconds)
        except (Exception, SystemExit) as error:
            _write(pipe, _failure(error))
    os._exit(0)


def _write(pipe: Any, packed: bytes) -> None:
    pipe.write(len(packed).to_bytes(LENGTH, "little"))
    pipe.write(packed)
    pipe.flush()


def _failure(error: BaseException) -> bytes:
    """Return an error packed, or its words if it is none that can be packed and unpacked."""
    try:
        packed = pickle.dumps((True, error))
        pickle.loads(packed)
    except Exception:
        packed = b""
    if packed and isinstance(error, Exception):
        return packed
    return pickle.dumps((True, RuntimeError(f"{type(error).__name__}: {error}")))


def _set_alarm(seconds: float) -> None:
    """Let the system end this process, also if the one that waits for it is gone."""
    signal.signal(signal.SIGALRM, signal.SIG_DFL)
    signal.setitimer(signal.ITIMER_REAL, seconds + 1.0)


def _limit(memory: int) -> None:
    import resource  # not on every system; here it is, as fork is

    resource.setrlimit(resource.RLIMIT_CORE, (0, resource.getrlimit(resource.RLIMIT_CORE)[1]))
    if sys.platform == "linux":
        soft, most = resource.getrlimit(resource.RLIMIT_AS)
        wanted = psutil.Process().memory_info().vms + memory
        given = [room for room in (soft, wanted) if room != resource.RLIM_INFINITY]
        resource.setrlimit(resource.RLIMIT_AS, (min(given), most))


class _Pipe:
    """The end of a pipe at which outcomes arrive."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._poll = select.poll()
        self._poll.register(descriptor, select.POLLIN)

    def take(self, seconds: float) -> bytes | None:
        """Return the next outcome, packed; None if the other end is closed.

        Raises
        ------
        ChildProcessDiedError
            It does not come in time.
        """
        deadline = time.monotonic() + seconds
        try:
            head = self._take_bytes(LENGTH, deadline)
            length = int.from_bytes(head, "little") if len(head) == LENGTH else -1
            packed = self._take_bytes(length, deadline)
        except TimeoutError as error:
            raise ChildProcessDiedError(f"takes longer than {seconds:g} s") from error
        return packed if len(packed) == length else None

    def _take_bytes(self, count: int, deadline: float) -> bytes:
        """Return so many bytes, fewer if the other end is closed before; or raise TimeoutError."""
        found = bytearray()
        while len(found) < count:
            left = deadline - time.monotonic()
            if left <= 0 or not self._poll.poll(1000 * left):
                raise TimeoutError
            chunk = os.read(self._descriptor, min(CHUNK, count - len(found)))
            if not chunk:
                break
            found += chunk
        return bytes(found)
