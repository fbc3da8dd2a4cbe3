"""The verb `barrier`: the way over the pass between two states."""

import argparse
from typing import Any

import xarray as xr

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.landscape.barrier import IMAGES, MODES, ROUNDS, barrier, describe_barrier
from bilayer.landscape.confirm_barrier import confirm_barrier, describe_confirmed, is_confirmed
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank
from bilayer.runtime.terminal import say
from bilayer.solvers.registry import SOLVERS


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "barrier",
        "bilayer barrier states.nc 0 1 -o way.nc",
    )  # fmt: skip
    verb.add_argument("states", metavar="STATES.nc", help="a file of `bilayer states`")
    verb.add_argument("first", type=int, metavar="I", help="a state by its number")
    verb.add_argument("second", type=int, metavar="K", help="another one")
    verb.add_argument(
        "-o", "--output", metavar="FILE.nc", help="keep the shapes along the way, a result"
    )
    verb.add_argument(
        "--images", type=int, default=IMAGES, metavar="N",
        help=f"shapes along the way, {IMAGES} if left out",
    )  # fmt: skip
    verb.add_argument(
        "--rounds", type=int, default=ROUNDS, metavar="N",
        help=f"rounds of their relaxation, {ROUNDS} if left out",
    )  # fmt: skip
    verb.add_argument(
        "--confirm", choices=[name for name in SOLVERS if name != "dshell"],
        help="the barrier by another solver, too, which starts from both states and the saddle",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status: 1 if no saddle was found, or it is not confirmed."""
    if not is_first_rank():
        return 0
    check_output(options, check_result_output)
    states = open_result(options.states)
    with progress_bar("barrier", shown=not options.quiet) as progress:
        way = barrier(
            states,
            options.first,
            options.second,
            images=options.images,
            rounds=options.rounds,
            progress=progress,
        )
    _give(way, describe_barrier(way, options.first, options.second), options)
    if way.attrs[MODES] < 0:
        return 1
    if options.confirm is not None:
        with progress_bar(options.confirm, shown=not options.quiet) as progress:
            confirmed = confirm_barrier(way, options.confirm, progress=progress)
        _give(confirmed, describe_confirmed(confirmed), options)
        return 0 if is_confirmed(confirmed) else 1
    return 0


def _give(way: xr.Dataset, words: str, options: argparse.Namespace) -> None:
    """Write what is known by now, and say it."""
    if options.output is not None:
        write_result(way, options.output)
    if not options.quiet:
        say(words)
