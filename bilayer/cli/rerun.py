"""The verb `rerun`: a result computed again, and whether the numbers agree."""

import argparse
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_json_argument, add_trust_argument, add_verb
from bilayer.errors import InputError
from bilayer.results.files import check_result_output, open_result
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank, join_mpi
from bilayer.runtime.terminal import say, say_json, tell
from bilayer.solvers.registry import solver_named
from bilayer.solvers.rerun import (
    AGREEMENT,
    agree,
    differences,
    rerun,
    select_reached_milestones,
    was_started_from_a_result,
)


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "rerun",
        "bilayer rerun result.nc",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument("-o", "--output", metavar="FILE.nc", help="keep the new result")
    add_trust_argument(verb)
    add_json_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status: 0 if the shapes agree."""
    join_mpi()
    first = is_first_rank()
    check_output(options, check_result_output)
    result = select_reached_milestones(open_result(options.result))
    if not (first or solver_named(result.attrs["solver"]).parallel):
        return 0  # the first rank computes alone
    if first and was_started_from_a_result(result):
        tell(
            f"bilayer: it was started from {result.attrs['start']}, which it does not hold; "
            "computed as usual"
        )
    title = f"{result.attrs['solver']} {result.attrs['model']}"
    with progress_bar(title, shown=first and not options.quiet) as progress:
        try:
            again = rerun(result, progress, options.output, trust=options.trust)
        except InputError as error:  # of what the file holds
            raise type(error)(f"result file {options.result}: {error}") from error
    table, good = differences(result, again), agree(result, again)
    if first and options.json:
        say_json({"agree": good, "differences": table.to_dict("records")})
    elif first:
        if not options.quiet:
            say(table.to_string(index=False, float_format=lambda value: f"{value:.3g}"))
        same = "to the last bit" if table["same_bits"].all() else f"to {AGREEMENT:g} of the radius"
        say(f"The two runs agree {same}." if good else "The two runs DO NOT AGREE.")
    return 0 if good else 1
