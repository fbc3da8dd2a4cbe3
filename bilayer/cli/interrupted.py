"""A run that was interrupted, as the command line tells it: one line, and the exit status."""

from collections.abc import Iterator

from bilayer.errors import Interrupted, Terminated
from bilayer.runtime.ranks import is_first_rank
from bilayer.runtime.terminal import tell

CTRL_C, TERMINATED = 130, 143
"""Exit statuses, as those of a shell whose command a signal ended."""


def tell_interruption(interrupt: KeyboardInterrupt) -> int:
    """Say on stderr what is kept; return the exit status."""
    line = "bilayer: interrupted"
    if isinstance(interrupt, Interrupted) and interrupt.output is not None:
        result = interrupt.result
        done, count = int(result["converged"].sum()), result.sizes["prestretch"]
        line += f"; {interrupt.output} has {done} of {count} milestones"
    if is_first_rank():
        tell(line)
    return TERMINATED if any(isinstance(link, Terminated) for link in _chain(interrupt)) else CTRL_C


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error, what caused it, and so on."""
    while error is not None:
        yield error
        error = error.__cause__
