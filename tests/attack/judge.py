"""What an attempt did to its folder and said, and whether that is right."""

from __future__ import annotations

import hashlib
import os
import re
import resource
import stat
from collections.abc import Mapping
from fnmatch import fnmatch
from pathlib import Path

from attack.attempt import Attempt, Right
from attack.child import Ended, in_child

LONGEST_LINE = 8000
"""Characters of an error that still is one line to read."""


def snapshot(folder: Path) -> dict[str, str]:
    """Return what lies in a folder: for each name its kind and a digest of its content."""
    found: dict[str, str] = {}
    for place, folders, files in os.walk(folder):
        for name in (*folders, *files):
            path = Path(place, name)
            found[os.fsdecode(os.path.relpath(path, folder))] = _what(path)
    return found


def _what(path: Path) -> str:
    mode = path.lstat().st_mode
    if stat.S_ISLNK(mode):
        return f"link to {path.readlink()}"
    if stat.S_ISREG(mode):
        return "file " + hashlib.sha1(path.read_bytes()).hexdigest()
    return f"kind {stat.S_IFMT(mode):o}"


def complaint(
    attempt: Attempt, ended: Ended, before: Mapping[str, str], after: Mapping[str, str], place: Path
) -> str:
    """Return what is wrong with what an attempt did, or an empty text."""
    for wrong in (_crash(attempt, ended), _said(attempt, ended)):
        if wrong:
            return wrong
    refused = ended.status == 2
    allowed = {
        Right.REFUSED: (2,),
        Right.ACCEPTED: (0,),
        Right.EITHER: (0, 2),
        Right.HANDLED: (0, 1, 2),
    }[attempt.right]
    if ended.status not in allowed:
        return f"exit status {ended.status}"
    wrong = _folder(() if refused else attempt.outputs, before, after)
    if wrong:
        return wrong
    if refused:
        wrong = _refusal(attempt, ended)
        if not wrong and attempt.refused_check is not None:
            wrong = in_child(lambda: attempt.refused_check(place, ended.stderr))
        return wrong
    if ended.status == 0:
        missing = [name for name in attempt.makes if name not in after]
        if missing:
            return f"makes no {missing[0]}"
        if attempt.check is not None:
            return in_child(lambda: attempt.check(place, ended.stdout + ended.stderr))
    return ""


def _crash(attempt: Attempt, ended: Ended) -> str:
    if ended.hung:
        return "hangs"
    if ended.status < 0:
        return f"signal {-ended.status}"
    if "Traceback (most recent call last)" in ended.stderr:
        if "--verbose" in attempt.words:
            return ""
        last = ended.stderr.strip().splitlines()[-1]
        return f"traceback: {last[:120]}"
    return ""


def _said(attempt: Attempt, ended: Ended) -> str:
    if "--verbose" in attempt.words:
        return ""
    for line in ended.stderr.splitlines():
        if line and not line.startswith("bilayer"):
            return f"says on stderr: {line[:120]}"
    if re.search(r"[\x00-\x08\x0b-\x1f\x7f\x9b]", ended.stderr):
        return "prints control characters on stderr"
    if attempt.says_not and re.search(attempt.says_not, ended.stdout + ended.stderr):
        found = re.search(attempt.says_not, ended.stdout + ended.stderr)
        return f"says {found[0][:80]!r}" if found else ""
    return ""


def _refusal(attempt: Attempt, ended: Ended) -> str:
    lines = [line for line in ended.stderr.splitlines() if line.strip()]
    closed = 2 in attempt.streams or attempt.limits.get(resource.RLIMIT_FSIZE) == 0
    if len(lines) != 1 and not closed and "--verbose" not in attempt.words:
        return f"{len(lines)} lines of error"
    if ended.stdout:
        return f"refused, but prints {ended.stdout.splitlines()[0][:60]!r}"
    if max(map(len, lines), default=0) > LONGEST_LINE:
        return f"an error of {max(map(len, lines))} characters"
    if attempt.says and not closed and not re.search(attempt.says, ended.stderr):
        return f"does not say {attempt.says!r}: {ended.stderr.strip()[:160]}"
    return ""


def _folder(patterns: object, before: Mapping[str, str], after: Mapping[str, str]) -> str:
    allowed = [str(pattern) for pattern in patterns]  # type: ignore[attr-defined]
    for name in (*before, *after):
        if before.get(name) == after.get(name) or any(fnmatch(name, p) for p in allowed):
            continue
        if name not in after:
            return f"{name} is gone"
        return f"{name} is left behind" if name not in before else f"{name} was changed"
    return ""
