"""The judge of the campaign sees what is wrong."""

from pathlib import Path

import pytest

from attack.attempt import Attempt, Right
from attack.child import Ended
from attack.judge import complaint, snapshot

LINE = "bilayer: error: mesh.size = -1 m: expected a number greater than 0\n"


def judged(right=Right.REFUSED, status=2, out="", err=LINE, hung=False, made=(), **attempt):
    """Return the complaint of an attempt that ended so."""
    tried = Attempt("kind", "name", ("mesh", "s.toml"), {}, right, **attempt)
    after = {"s.toml": "file 1", **dict.fromkeys(made, "file 2")}
    ended = Ended(status, out, err, hung, 0.1, 0.1)
    return complaint(tried, ended, {"s.toml": "file 1"}, after, Path())


def test_what_is_right_is_not_complained_of():
    assert judged() == ""
    assert judged(Right.ACCEPTED, 0, "a table\n", "", made=["m.msh"], outputs=["m.*"]) == ""
    assert judged(Right.HANDLED, 1) == ""
    assert judged(says=r"mesh\.size") == ""


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"status": 0, "err": ""}, "exit status 0"),
        ({"right": Right.ACCEPTED}, "exit status 2"),
        ({"right": Right.EITHER, "status": 1}, "exit status 1"),
        ({"status": -11, "err": ""}, "signal 11"),
        ({"status": 1, "err": "Traceback (most recent call last):\nKeyError: 1\n"}, "KeyError"),
        ({"hung": True, "status": -9}, "hangs"),
        ({"err": LINE + LINE}, "2 lines"),
        ({"err": ""}, "0 lines"),
        ({"err": "x.py:1: RuntimeWarning: overflow\n" + LINE}, "RuntimeWarning"),
        ({"err": LINE.replace("mesh", "\x1b[31m")}, "control characters"),
        ({"out": "half a table"}, "prints"),
        ({"says": "corner_size"}, "does not say"),
        ({"says_not": "greater"}, "says"),
        ({"made": ["a.nc"]}, "a.nc is left behind"),
        ({"made": ["s.toml"]}, "s.toml was changed"),
        ({"right": Right.ACCEPTED, "status": 0, "err": "", "makes": ["a.nc"]}, "makes no a.nc"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_seen(wrong, complaint):
    assert complaint in judged(**wrong)


def test_a_snapshot_tells_files_links_and_pipes_apart(tmp_path):
    (tmp_path / "a").write_text("x")
    (tmp_path / "b").symlink_to("a")
    before = snapshot(tmp_path)
    (tmp_path / "b").unlink()
    (tmp_path / "b").write_text("x")
    assert snapshot(tmp_path) != before
