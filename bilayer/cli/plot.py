"""The verb `plot`: the shapes of a result as a picture."""

import argparse
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.results.files import open_result


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "plot",
        "bilayer plot fenics.nc -o shape.png",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "-o", "--output", required=True, metavar="FIGURE", help="the picture: .png, .pdf, .svg, ..."
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures import draw_shapes, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output

    check_output(options, check_figure_output)
    save_figure(draw_shapes(open_result(options.result)), options.output)
    return 0
