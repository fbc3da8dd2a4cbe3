"""Progress where nobody looks: lines in a log, not too many."""

from bilayer.runtime import progress
from bilayer.runtime.progress import progress_bar


def test_a_log_gets_a_line_now_and_then(capsys, monkeypatch):
    now = 0.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with progress_bar("dshell") as tell:
        for percent in range(101):
            now = float(percent)
            tell(percent / 100, f"prestretch 1.{percent:02d}")
    assert capsys.readouterr().err.splitlines() == [
        "dshell: 30%, prestretch 1.30, 30 s",
        "dshell: 60%, prestretch 1.60, 60 s",
        "dshell: 90%, prestretch 1.90, 90 s",
    ]


def test_quiet_is_quiet(capsys, monkeypatch):
    monkeypatch.setattr(progress, "SECONDS_BETWEEN_LINES", 0.0)
    with progress_bar("dshell", shown=False) as tell:
        tell(0.5, "prestretch 1.03")
    assert capsys.readouterr().err == ""
