"""Progress of a run on stderr: a bar on a terminal, a line from time to time in a log."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from bilayer.runtime.terminal import tell

Progress = Callable[[float, str], None]
"""Called with the fraction done, from 0 to 1, and a few words on the state of the run."""

SECONDS_BETWEEN_LINES = 30.0
"""In a log; a run that takes less says nothing there."""


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
        yield _lines(title)
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


def _lines(title: str) -> Progress:
    begin = last = time.monotonic()

    def progress(fraction: float, message: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= SECONDS_BETWEEN_LINES:
            last = now
            tell(f"{title}: {fraction:.0%}, {message}, {now - begin:.0f} s")

    return progress
