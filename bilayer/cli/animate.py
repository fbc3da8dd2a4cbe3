"""The verb `animate`: the shapes of a result one after the other, as a GIF or a film."""

import argparse
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_trust_argument, add_verb
from bilayer.cli.plot import number, view_argument
from bilayer.errors import InputError
from bilayer.results.files import open_result
from bilayer.runtime.progress import progress_bar
from bilayer.validation import whole


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "animate",
        "bilayer animate shell.nc -o popping.gif --between 4",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "-o", "--output", required=True, metavar="FILE", help="the animation: .gif or .mp4"
    )
    verb.add_argument(
        "--between", metavar="N", default="0",
        help="compute N equilibria between any two milestones; without it, the milestones alone "
        "are shown. Nothing is blended",
    )  # fmt: skip
    verb.add_argument(
        "--view", metavar="V", default="isometric",
        help="isometric, above, front, or azimuth and elevation of the eye in degrees as '30,20' "
        "(default: isometric)",
    )  # fmt: skip
    verb.add_argument("--seconds", metavar="S", default="5", help="how long it lasts (default: 5)")
    add_trust_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures.animation import check_animation_output, save_animation
    from bilayer.solvers.between import solve_between

    check_output(options, check_animation_output)
    between = whole("--between", number("--between", options.between), at_least=0)
    view, seconds = view_argument(options.view), number("--seconds", options.seconds)
    result = open_result(options.result)
    if not result["converged"].values.any():
        raise InputError(f"result file {options.result}: has no milestone that was reached")
    if between:
        with progress_bar("equilibria between", shown=not options.quiet) as progress:
            result = solve_between(result, between, progress, trust=options.trust)
    save_animation(result, options.output, view=view, seconds=seconds)
    return 0
