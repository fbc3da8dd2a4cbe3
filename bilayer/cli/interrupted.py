"""A run that was interrupted, as the command line tells it: one line, and the exit status."""

from collections.abc import Iterator
from typing import Any

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
        line += f"; {interrupt.output} has {_kept(result)}"
    if is_first_rank():
        tell(line)
    return TERMINATED if any(isinstance(link, Terminated) for link in _chain(interrupt)) else CTRL_C


def _kept(result: Any) -> str:
    from bilayer.results.schema import TIMES_FOUND  # xarray is there already

    count = result.sizes["prestretch"]
    if TIMES_FOUND in result:
        return f"{count} states, from {result.attrs['start']}"
    return f"{int(result['converged'].sum())} of {count} milestones"


def _chain(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error, what caused it, and so on."""
    while error is not None:
        yield error
        error = error.__cause__
