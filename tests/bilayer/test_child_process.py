"""Work in a child process: its outcome, its errors, and what it meets that would end this one."""

import ctypes
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import psutil
import pytest

from bilayer.errors import InputError
from bilayer.runtime.child_process import ChildProcessDiedError, outcomes_of_child, run_in_child

ROOM = 2**28


def test_the_outcome_is_handed_back():
    large = run_in_child(lambda: np.arange(300_000.0), 10.0, ROOM)
    assert np.array_equal(large, np.arange(300_000.0))
    assert run_in_child(os.getpid, 10.0, ROOM) != os.getpid()


def refuse():
    raise InputError("size = 3: expected 4")


class OddError(Exception):
    """It cannot be made again from what is pickled of it."""

    def __init__(self, first, second):
        super().__init__(f"{first} {second}")


def refuse_oddly():
    raise OddError(1, 2)


def leave():
    raise SystemExit("left")


@pytest.mark.parametrize(
    ("action", "kind", "message"),
    [
        (refuse, InputError, "size = 3"),
        (refuse_oddly, RuntimeError, "OddError: 1 2"),
        (leave, RuntimeError, "SystemExit: left"),
        (lambda: np.ones(2**34), MemoryError, ""),
    ],
)
def test_an_error_is_raised_here(action, kind, message):
    with pytest.raises(kind, match=message):
        run_in_child(action, 10.0, ROOM)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda: ctypes.string_at(0), "SIGSEGV"),
        (os.abort, "SIGABRT"),
        (lambda: os.kill(os.getpid(), signal.SIGKILL), "SIGKILL"),
        (lambda: os._exit(3), "status 3"),
    ],
)
def test_a_crash_ends_the_child_alone_and_says_nothing(action, message, capfd):
    with pytest.raises(ChildProcessDiedError, match=message):
        run_in_child(action, 10.0, ROOM)
    assert capfd.readouterr() == ("", "")


def test_a_child_that_never_ends_is_ended():
    begin, before = time.monotonic(), psutil.Process().children()
    with pytest.raises(ChildProcessDiedError, match=r"takes longer than 0\.3 s"):
        run_in_child(lambda: time.sleep(60), 0.3, ROOM)
    assert time.monotonic() - begin < 20
    assert psutil.Process().children() == before


def test_outcomes_come_until_the_child_dies():
    def three():
        yield 1
        yield 2
        os.abort()

    found = outcomes_of_child(three, 10.0, ROOM)
    assert [next(found), next(found)] == [1, 2]
    with pytest.raises(ChildProcessDiedError, match="SIGABRT"):
        next(found)


def test_it_works_beside_other_threads():
    busy = threading.Event()
    other = threading.Thread(target=busy.wait)
    other.start()
    try:
        assert run_in_child(lambda: 4, 10.0, ROOM) == 4
    finally:
        busy.set()
        other.join()


def test_the_child_does_not_outlive_the_process_that_waits(tmp_path):
    code = (
        "import os, time\nfrom bilayer.runtime.child_process import run_in_child\n"
        "def work():\n    print_to(os.getpid())\n    time.sleep(60)\n"
        "def print_to(pid):\n    open({0!r}, 'w').write(str(pid))\n"
        "run_in_child(work, 1.0, 2**28)\n"
    )
    noted = tmp_path / "child"
    parent = subprocess.Popen([sys.executable, "-c", code.format(str(noted))])
    while not (noted.exists() and noted.read_text()):
        assert parent.poll() is None
        time.sleep(0.01)
    parent.kill()
    parent.wait()
    child = Path("/proc", noted.read_text())
    for _ in range(600):
        if not child.exists():
            return
        time.sleep(0.05)
    raise AssertionError("the child is still there")
