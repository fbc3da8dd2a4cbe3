"""The command line in a child of this process: everything is loaded, so it takes milliseconds."""

from __future__ import annotations

import contextlib
import multiprocessing.util
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import psutil

SECONDS = 20.0
"""A command that computes or waits for longer hangs."""
BETWEEN_LOOKS, IDLE = 5.0, 0.02
"""Seconds between two looks at a command of more than `SECONDS`; CPU seconds of one that waits."""
LONGEST = 15.0
"""So many times as long a command may take on a busy machine."""
ROOM = 4 * 2**30
"""Bytes that a child may take beside those of its parent."""
WITHOUT_LAUNCHER = ("OMPI_COMM", "PMIX", "PRTE")


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit status (negative: a signal), what it printed, whether it hung."""

    status: int
    stdout: str
    stderr: str
    hung: bool
    seconds: float
    cpu: float


def load_everything() -> None:
    """Load what the verbs load when they are used, and start MPI, for all children at once."""
    import scipy.stats.qmc  # noqa: F401

    import bilayer.figures
    import bilayer.study.figure  # noqa: F401
    import dshell.solver  # noqa: F401
    from bilayer.cli import main  # noqa: F401
    from bilayer.runtime.ranks import join_mpi
    from bilayer.specimen.units import in_si

    in_si("specimen", {"outer_radius": "1 mm"})  # the registry of the units
    with contextlib.suppress(ImportError):
        import fenics_model.solver  # noqa: F401
    join_mpi()


def run_forked(
    words: Sequence[str],
    folder: Path,
    variables: Mapping[str, str | None],
    streams: Mapping[int, str],
    limits: Mapping[int, int],
) -> Ended:
    """Run the command line in a fork of this process."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # libraries have threads; none of them is at work
            process = os.fork()
        if process == 0:
            _become(words, folder, variables, streams, limits, out.fileno(), err.fileno())
        status, hung, cpu = _wait(process, begin)
        return Ended(status, _text(out), _text(err), hung, time.monotonic() - begin, cpu)


def run_fresh(
    words: Sequence[str],
    folder: Path,
    variables: Mapping[str, str | None],
    streams: Mapping[int, str],
    limits: Mapping[int, int],
) -> Ended:
    """Run the command line in a process of its own, as a user does."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(WITHOUT_LAUNCHER)}
    for name, value in variables.items():
        environment.pop(name, None)
        if value is not None:
            environment[name] = value

    def prepare() -> None:
        os.setpgid(0, 0)
        _open_streams(streams)
        for number, limit in limits.items():
            resource.setrlimit(number, (limit, limit))

    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        begin = time.monotonic()
        running = subprocess.Popen(
            [sys.executable, "-P", "-m", "bilayer", *words],
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=err,
            preexec_fn=prepare,
        )
        status, hung, cpu = _wait(running.pid, begin)
        running.returncode = status
        return Ended(status, _text(out), _text(err), hung, time.monotonic() - begin, cpu)


def in_child(check: Callable[[], str], seconds: float = SECONDS) -> str:
    """Return what a function returns in a fork of this process, which it cannot harm or hold up."""
    with tempfile.TemporaryFile() as told, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        begin, process = time.monotonic(), os.fork()
        if process == 0:
            try:
                os.setpgid(0, 0)
                os.write(told.fileno(), check().encode())
            except BaseException as error:
                os.write(told.fileno(), f"the check ends with {error!r}".encode())
            finally:
                os._exit(0)
        status, hung, _ = _wait(process, begin, seconds)
        return "the check of what was written hangs" if hung or status else _text(told)


def _become(
    words: Sequence[str],
    folder: Path,
    variables: Mapping[str, str | None],
    streams: Mapping[int, str],
    limits: Mapping[int, int],
    out: int,
    err: int,
) -> NoReturn:
    """Be the command; never return."""
    status = 1
    try:
        os.setpgid(0, 0)
        os.chdir(folder)
        for number, opened in ((0, os.open(os.devnull, os.O_RDONLY)), (1, out), (2, err)):
            os.dup2(opened, number)
        _open_streams(streams)
        sys.stdin, sys.stdout, sys.stderr = (
            _stream(number, mode) for number, mode in ((0, "r"), (1, "w"), (2, "w"))
        )
        for name, value in variables.items():
            os.environ.pop(name, None)
            if value is not None:
                os.environ[name] = value
        tempfile.tempdir = None
        signal.signal(signal.SIGINT, signal.default_int_handler)
        room = psutil.Process().memory_info().vms + ROOM
        resource.setrlimit(resource.RLIMIT_AS, (room, room))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        for number, limit in limits.items():
            resource.setrlimit(number, (limit, limit))
        sys.argv = ["bilayer", *words]
        warnings.simplefilter("default")
        status = _status_of_command()
    finally:
        os._exit(status)


def _status_of_command() -> int:
    import bilayer.__main__ as command

    sys.modules["__main__"] = command  # what a process that it starts begins with
    try:
        status: Any = command.main()
    except SystemExit as stop:
        status = stop.code
    except BaseException:
        traceback.print_exc()
        status = 1
    multiprocessing.util._run_finalizers()  # as at Python's own end: they remove folders
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:
                stream.flush()
    except (OSError, ValueError):
        return 120  # as Python's own end
    return status if isinstance(status, int) else int(status is not None)


def _open_streams(streams: Mapping[int, str]) -> None:
    for number, where in streams.items():
        if where == "closed":
            os.close(number)
        else:
            os.dup2(os.open(where, os.O_RDWR), number)


def _stream(number: int, mode: str) -> Any:
    try:
        os.fstat(number)
    except OSError:
        return None  # as Python does for a closed one
    return open(number, mode, encoding="utf-8", errors="surrogateescape", closefd=False)


def _wait(process: int, begin: float, seconds: float = SECONDS) -> tuple[int, bool, float]:
    """Return exit status, whether it hung (and was ended), and the CPU time."""
    watch = _Watch(process, begin, seconds)
    hung = False
    pause = 0.001
    while True:
        ended, status, used = os.wait4(process, os.WNOHANG)
        if ended:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process, signal.SIGKILL)  # what it may have left running
            return os.waitstatus_to_exitcode(status), hung, used.ru_utime + used.ru_stime
        if not hung and watch.sees_it_hang():
            hung = True
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process, signal.SIGKILL)
        time.sleep(pause)
        pause = min(1.3 * pause, 0.05)


class _Watch:
    """Sees whether a process has computed for too long, or waits; a busy machine counts for none.

    Parameters
    ----------
    process : int
        Its number.
    begin : float
        When it began, of the monotonic clock.
    seconds : float
        Of computing, and until the first look.
    """

    def __init__(self, process: int, begin: float, seconds: float) -> None:
        self._process, self._seconds = process, seconds
        self._begin, self._next, self._cpu = begin, begin + seconds, 0.0

    def sees_it_hang(self) -> bool:
        """Look from time to time; return whether it hangs."""
        now = time.monotonic()
        if now < self._next:
            return False
        self._next = now + BETWEEN_LOOKS
        cpu, before = self._cpu_so_far(), self._cpu
        self._cpu = cpu
        waits = now > self._begin + self._seconds + BETWEEN_LOOKS / 2 and abs(cpu - before) < IDLE
        return waits or cpu > self._seconds or now - self._begin > LONGEST * self._seconds

    def _cpu_so_far(self) -> float:
        with contextlib.suppress(psutil.NoSuchProcess):
            whole = psutil.Process(self._process)
            times = [p.cpu_times() for p in (whole, *whole.children(recursive=True))]
            return sum(t.user + t.system + t.children_user + t.children_system for t in times)
        return self._cpu


def _text(file: Any) -> str:
    file.seek(0)
    return file.read(10_000_000).decode("utf-8", errors="replace")
