r"""The words of a process: what was asked for on stdout, progress and errors on stderr.

Nothing else writes to either. Text from files is shown as text: an escape sequence or a newline in
a name is written out, as in "\u001b[2J", and moves no cursor and makes no line.
"""

import io
import json
import math
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

Notice = Callable[[str], None]
"""Takes a line of text for the user."""
LONGEST_LINE = 2000
"""Letters of a line on stderr."""
_RED, _YELLOW = "1;31", "1;33"
_ERROR = re.compile(r"(?<=^bilayer: )error(?=:)")
_WARNING = re.compile(r"(?<=^bilayer: )warning(?=:)")
_ALARM = re.compile(r"\b[A-Z]{2,}(?: [A-Z]+)+\b")
"""Words in capitals, as in "NOT STABLE"."""
_KEPT = frozenset("\n\t")
_SHORT = {"\n": "\\n", "\t": "\\t", "\r": "\\r"}
"""Written out as in TOML, so that a specimen that is shown reads back the same."""


def printable(text: object) -> str:
    r"""Return a text in which all that is not printed, but for newlines and tabs, is written out.

    Examples
    --------
    >>> printable("one\ttwo\x1b[31m\n")
    'one\ttwo\\u001b[31m\n'
    """
    return "".join(_shown(letter, _KEPT) for letter in str(text))


def one_line(text: object) -> str:
    r"""Return a text in one line: newlines and tabs are written out, too.

    Examples
    --------
    >>> one_line("paper\nTo run it again:")
    'paper\\nTo run it again:'
    """
    return "".join(_shown(letter) for letter in str(text))


def _shown(letter: str, kept: frozenset[str] = frozenset()) -> str:
    if letter.isprintable() or letter in kept:
        return letter
    code = ord(letter)
    return _SHORT.get(letter) or (f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}")


def say(text: object, end: str = "\n") -> None:
    """Write a text to stdout: what a verb was asked for. A terminal gets alarms in colour.

    Raises
    ------
    OSError
        It cannot be written: the disk is full, or the reader has gone (BrokenPipeError).
    """
    if sys.stdout is not None:  # it is None where it was closed
        shown = printable(text)
        print(_coloured(shown, _ALARM, _YELLOW) if _has_colours(sys.stdout) else shown, end=end)


def say_json(value: Any) -> None:
    """Write a value to stdout as JSON, which a program reads; not finite numbers become null.

    Raises
    ------
    OSError
        It cannot be written.
    """
    say(json.dumps(_finite(value), indent=2, allow_nan=False))


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(inner) for inner in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def tell(text: object) -> None:
    """Write a line to stderr; what cannot be written there is lost and stops nothing.

    On a terminal the word "error" or "warning" at its beginning is in colour.
    """
    with suppress(OSError, ValueError):
        line = _of_a_length(one_line(text))
        if _has_colours(sys.stderr):
            line = _coloured(_coloured(line, _ERROR, _RED), _WARNING, _YELLOW)
        print(line, file=sys.stderr or io.StringIO(), flush=True)


def _has_colours(stream: Any) -> bool:
    """Whether a stream is a terminal with colours whose user wants them (https://no-color.org)."""
    if stream is None or os.environ.get("NO_COLOR") or os.environ.get("TERM", "dumb") == "dumb":
        return False
    with suppress(ValueError, AttributeError):
        return bool(stream.isatty())
    return False


def _coloured(text: str, pattern: re.Pattern[str], colour: str) -> str:
    """Return a text that is printable, in which what a pattern finds has a colour."""
    return pattern.sub(lambda found: f"\x1b[{colour}m{found[0]}\x1b[0m", text)


def _of_a_length(line: str) -> str:
    """Return a line, if it is very long without its middle: a whole file may stand in it."""
    if len(line) <= LONGEST_LINE:
        return line
    return f"{line[: LONGEST_LINE // 2]} ... {line[-LONGEST_LINE // 2 :]}"


def warn(text: object) -> None:
    """Write a line of what the user should know to stderr, as a warning."""
    tell(f"bilayer: warning: {text}")


def keep_quiet(line: str) -> None:
    """Tell nobody: a `Notice`."""


def tell_lines(text: object) -> None:
    """Write several lines to stderr, such as the trace of an error."""
    for line in str(text).splitlines():
        tell(line)


def open_standard_streams() -> None:
    """Make stdin, stdout and stderr fit to be written to, whatever this process was started with.

    Closed ones become the null device: else the next file that is opened would take their place,
    and what a library prints would land in it. A letter that a stream cannot hold is written out.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            with suppress(OSError):
                os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    sys.stdout = _fit(sys.stdout)
    sys.stderr = _Forgiving(_fit(sys.stderr))  # type: ignore[assignment]


def _fit(stream: TextIO | None) -> TextIO:
    if stream is None:
        return Path(os.devnull).open("w", encoding="utf-8")
    if isinstance(stream, io.TextIOWrapper):
        stream.reconfigure(errors="backslashreplace")
    return stream


class _Forgiving:
    """A stream that loses what its reader no longer takes, as in `2>&1 | head -1`.

    Progress and warnings must not end a computation.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text, if it can be written."""
        with suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Flush, if it can be done."""
        with suppress(OSError, ValueError):
            self._stream.flush()


def flush_stdout() -> None:
    """Hand on what stdout still holds.

    Raises
    ------
    OSError
        It cannot be written: on a full disk.
    """
    try:
        if sys.stdout is not None:
            sys.stdout.flush()
    except BrokenPipeError:  # the reader has had enough, as in `bilayer init | head -3`
        drop_stdout()


def drop_stdout() -> None:
    """Let what stdout still holds go, and all that is written to it from now on."""
    with suppress(OSError, ValueError, AttributeError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.stdout.flush()
