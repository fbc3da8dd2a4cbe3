"""The progress bar of a run, on stderr, where a person looks at it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from tqdm import tqdm

from bilayer.solvers import Progress


@contextmanager
def progress_bar(title: str, shown: bool = True) -> Iterator[Progress]:
    """Give a progress callback that draws a bar on a terminal, and nothing elsewhere.

    Parameters
    ----------
    title : str
        Stands before the bar.
    shown : bool
        False draws nothing.
    """
    layout = "{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining} {postfix}"
    with tqdm(
        total=100,
        unit="%",
        desc=title,
        bar_format=layout,
        disable=None if shown else True,  # None: disabled where stderr is no terminal
        file=sys.stderr,
        dynamic_ncols=True,
    ) as bar:

        def progress(fraction: float, message: str) -> None:
            bar.set_postfix_str(message, refresh=False)
            bar.update(max(int(100 * fraction) - bar.n, 0))

        yield progress
