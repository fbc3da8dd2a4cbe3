"""Progress where nobody looks: lines in a log, not too many, also while a step takes long."""

import io
import os
import pty
import sys
import time

import pytest

from bilayer.runtime import progress
from bilayer.runtime.progress import progress_bar


@pytest.fixture
def quickly(monkeypatch):
    """A line after 0.1 s, and then every 0.2 s."""
    monkeypatch.setattr(progress, "SECONDS_TO_FIRST_LINE", 0.1)
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.2)


def test_a_log_gets_a_line_now_and_then(quickly, capsys):
    with progress_bar("dshell") as tell:
        tell(0.30, "prestretch 1.30")
        time.sleep(0.5)
        for percent in range(40, 61):
            tell(percent / 100, f"prestretch 1.{percent}")
        time.sleep(0.3)
    lines = [line.rpartition(", ")[0] for line in capsys.readouterr().err.splitlines()]
    assert set(lines) == {"dshell: 30%, prestretch 1.30", "dshell: 60%, prestretch 1.60"}
    assert 2 <= len(lines) <= 5
    time.sleep(0.3)
    assert capsys.readouterr().err == ""


def test_a_step_that_takes_long_is_told(quickly, capsys):
    with progress_bar("mesh"):
        time.sleep(0.2)
    assert capsys.readouterr().err.startswith("mesh: 0%, begun, 0 s\n")


def test_a_run_that_ends_soon_says_nothing(capsys):
    with progress_bar("dshell") as tell:
        tell(0.5, "prestretch 1.03")
    assert capsys.readouterr().err == ""


def test_quiet_is_quiet(quickly, capsys):
    with progress_bar("dshell", shown=False) as tell:
        tell(0.5, "prestretch 1.03")
        time.sleep(0.2)
    assert capsys.readouterr().err == ""


class Screen(io.StringIO):
    """A terminal."""

    def isatty(self):
        return True


def test_a_terminal_gets_a_sign_while_a_step_takes_long(monkeypatch):
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_BARS", 0.05)
    monkeypatch.setattr(progress, "SECONDS_UNTOLD", 0.2)
    monkeypatch.setattr("sys.stderr", Screen())
    with progress_bar("fenics") as tell:
        tell(0.25, "searching for a stable branch")
        time.sleep(0.5)
        drawn = sys.stderr.getvalue()
        tell(1.0, "prestretch 1.24")
    assert drawn.count("searching for a stable branch") >= 4
    assert "searching for a stable branch, 0 s" in drawn
    assert "25%" in drawn
    assert "100%" in sys.stderr.getvalue().removeprefix(drawn)


def test_a_terminal_without_columns_gets_lines(quickly, monkeypatch):
    reading, writing = pty.openpty()  # its size is 0 x 0
    with os.fdopen(writing, "w") as terminal:
        monkeypatch.setattr("sys.stderr", terminal)
        with progress_bar("dshell") as tell:
            tell(0.5, "prestretch 1.03")
            time.sleep(0.2)
        terminal.flush()
        assert b"dshell: 50%, prestretch 1.03" in os.read(reading, 1000)
    os.close(reading)
