"""Progress of a run on stderr: a bar on a terminal, a line from time to time in a log."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bilayer.runtime.terminal import tell

Progress = Callable[[float, str], None]
"""Called with the fraction done, from 0 to 1, and a few words on the state of the run."""

SECONDS_TO_FIRST_LINE = 10.0
SECONDS_BETWEEN_LINES = 10.0
"""In a log; a run that takes less says nothing there."""


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


@contextmanager
def progress_bar(title: str, shown: bool = True) -> Iterator[Progress]:
    """Give a progress callback that draws a bar on a terminal, and writes lines elsewhere.

    Parameters
    ----------
    title : str
        Stands before the bar, and in every line.
    shown : bool
        False shows nothing.
    """
    if shown and not sys.stderr.isatty():
        with _lines(title) as in_lines:
            yield in_lines
        return
    from tqdm import tqdm

    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining} {postfix}"
    with tqdm(
        total=100,
        unit="%",
        desc=title,
        bar_format=layout,
        disable=not shown,
        file=sys.stderr,
        dynamic_ncols=True,
    ) as bar:

        def progress(fraction: float, message: str) -> None:
            bar.set_postfix_str(message, refresh=False)
            bar.update(max(int(100 * fraction) - bar.n, 0))

        yield progress


@contextmanager
def _lines(title: str) -> Iterator[Progress]:
    """Write lines from a thread of their own: one step of a run may take long."""
    begin = time.monotonic()
    latest = [0.0, "begun"]
    ended = threading.Event()

    def progress(fraction: float, message: str) -> None:
        latest[:] = fraction, message

    def write_lines() -> None:
        seconds = SECONDS_TO_FIRST_LINE
        while not ended.wait(seconds):
            fraction, message = latest
            tell(f"{title}: {fraction:.0%}, {message}, {time.monotonic() - begin:.0f} s")
            seconds = SECONDS_BETWEEN_LINES

    writer = threading.Thread(target=write_lines, daemon=True)
    writer.start()
    try:
        yield progress
    finally:
        ended.set()
        writer.join()
