"""The verb `compare`: two results beside one another."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.results.comparison import compare, comparison_table
from bilayer.results.files import open_result
from bilayer.runtime.terminal import say


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "compare",
        "bilayer compare fenics.nc shell.nc -o comparison.png",
    )  # fmt: skip
    verb.add_argument("results", nargs=2, metavar="FILE.nc")
    verb.add_argument("-o", "--output", metavar="FIGURE", help="also draw the comparison")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures import draw_comparison, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output

    check_output(options, check_figure_output)
    first, second = (open_result(path) for path in options.results)
    comparison = compare(first, second)
    if comparison.attrs["first"] == comparison.attrs["second"]:  # the files tell them apart
        for side, path in zip(("first", "second"), options.results, strict=True):
            comparison.attrs[side] += f" ({Path(path).name})"
    if not options.quiet:
        say(comparison_table(comparison))
    if options.output is not None:
        save_figure(draw_comparison(comparison), options.output)
    return 0
