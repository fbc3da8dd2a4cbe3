"""Progress of a run on stderr: a bar on a terminal, a line from time to time in a log."""

import os
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bilayer.runtime.terminal import one_line, tell

Progress = Callable[[float, str], None]
"""Called with the fraction done, from 0 to 1, and a few words on the state of the run."""

SECONDS_TO_FIRST_LINE = 10.0
SECONDS_BETWEEN_LINES = 10.0
"""In a log; a run that takes less says nothing there."""
SECONDS_BETWEEN_BARS = 0.5
SECONDS_UNTOLD = 3.0
"""Time of a step from which on a bar says how long it has been at it."""


def never_back(progress: Progress) -> Progress:
    """Return a callback that hands on the largest fraction so far.

    Whoever knows only what is being done may give 0.

    Examples
    --------
    >>> tell = never_back(lambda fraction, message: print(fraction, message))
    >>> tell(0.25, "prestretch 1.03")
    0.25 prestretch 1.03
    >>> tell(0.0, "Newton iteration 1")
    0.25 Newton iteration 1
    """
    most = 0.0

    def tell_on(fraction: float, message: str) -> None:
        nonlocal most
        most = max(most, fraction)
        progress(most, message)

    return tell_on


class _Latest:
    """The latest report of a run, and for how long it has been that; thread-safe by assignment."""

    def __init__(self) -> None:
        self._report = (0.0, "begun", time.monotonic())

    def __call__(self, fraction: float, message: str) -> None:
        since = self._report[2] if message == self._report[1] else time.monotonic()
        self._report = (fraction, message, since)

    @property
    def fraction(self) -> float:
        return self._report[0]

    @property
    def message(self) -> str:
        return self._report[1]

    @property
    def words(self) -> str:
        """What is being done; for how long, if it takes its time."""
        _, message, since = self._report
        held = time.monotonic() - since
        return message if held < SECONDS_UNTOLD else f"{message}, {held:.0f} s"


@contextmanager
def progress_bar(title: str, shown: bool = True) -> Iterator[Progress]:
    """Give a progress callback that draws a bar on a terminal, and writes lines elsewhere.

    A bar moves every second and says what is being done, also while a step takes long.

    Parameters
    ----------
    title : str
        Stands before the bar, and in every line.
    shown : bool
        False shows nothing.
    """
    latest = _Latest()
    if not shown:
        yield latest
    elif _has_room_for_bars() or in_notebook():
        with _bar(title, latest):
            yield latest
    else:
        with _lines(title, latest):
            yield latest


def _has_room_for_bars() -> bool:
    """Whether stderr is a terminal, and not one that says it has no columns.

    A terminal of another program (script, expect, ssh -tt, a container's) may have no size; a bar
    would be empty there.
    """
    if not sys.stderr.isatty():
        return False
    try:
        return os.get_terminal_size(sys.stderr.fileno()).columns > 0
    except (OSError, ValueError):  # not known
        return True


def in_notebook() -> bool:
    """Whether this process is the kernel of a notebook."""
    shell = sys.modules.get("IPython")
    running = shell.get_ipython() if shell is not None and "ipykernel" in sys.modules else None
    return running is not None and type(running).__name__ == "ZMQInteractiveShell"


@contextmanager
def progress_asked(title: str, asked: Progress | bool | None) -> Iterator[Progress | None]:
    """Give the callback that a function was asked for by its argument `progress`.

    Parameters
    ----------
    title : str
        Of a bar.
    asked : callable, bool or None
        A callback is given as it is; True is a bar, False nothing, None a bar in a notebook alone.
    """
    if asked is None:
        asked = in_notebook()
    if callable(asked):
        yield asked
    elif asked:
        with progress_bar(title) as progress:
            yield progress
    else:
        yield None


@contextmanager
def _bar(title: str, latest: _Latest) -> Iterator[None]:
    """Draw a bar from a thread of its own; in a notebook one of its own kind, if it has any."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # tqdm warns of a notebook without widgets
        from tqdm.auto import tqdm

    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}{postfix}"
    with tqdm(
        total=100, desc=title, bar_format=layout, file=sys.stderr, dynamic_ncols=True
    ) as bar:  # fmt: skip

        def draw() -> None:
            bar.n = max(bar.n, int(100 * latest.fraction))
            bar.set_postfix_str(one_line(latest.words), refresh=False)
            bar.refresh()

        with _again_and_again(draw, SECONDS_BETWEEN_BARS, SECONDS_BETWEEN_BARS):
            yield
        draw()


@contextmanager
def _lines(title: str, latest: _Latest) -> Iterator[None]:
    """Write lines from a thread of their own: one step of a run may take long."""
    begin = time.monotonic()

    def write() -> None:
        seconds = time.monotonic() - begin
        tell(f"{title}: {latest.fraction:.0%}, {latest.message}, {seconds:.0f} s")

    with _again_and_again(write, SECONDS_TO_FIRST_LINE, SECONDS_BETWEEN_LINES):
        yield


@contextmanager
def _again_and_again(action: Callable[[], None], first: float, then: float) -> Iterator[None]:
    """Do something in a thread after some seconds, and then from time to time."""
    ended = threading.Event()

    def repeat() -> None:
        seconds = first
        while not ended.wait(seconds):
            action()
            seconds = then

    thread = threading.Thread(target=repeat, daemon=True)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
