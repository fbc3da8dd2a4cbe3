"""The verb `design`: from a target shape to a specimen and its cut files."""

import argparse
from typing import Any

from bilayer.cli.parser import add_verb
from bilayer.designing.report import write_design
from bilayer.designing.run import Tried, design
from bilayer.designing.task import read_design
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.terminal import one_line, say, tell


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "design",
        "bilayer design design.toml -o dome",
    )  # fmt: skip
    verb.add_argument("design", metavar="FILE.toml", help="the design file")
    verb.add_argument(
        "-o", "--output", required=True, metavar="DIR",
        help="the design's folder; a second start goes on where the first one ended",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    task = read_design(options.design)
    shown = not options.quiet
    with progress_bar("design", shown=shown) as progress:
        outcome = design(
            task,
            options.output,
            progress=progress,
            observer=_tell_failure if options.verbose else None,
        )
    report = write_design(outcome, options.output)
    if shown:
        found = outcome.from_flat.shapes[0]
        share = found.distance / task.target.diagonal
        say(f"shell: {1e3 * found.distance:.4g} mm from the target, {share:.2%} of its diagonal")
        for check in outcome.checks:
            away = check.distance.rms
            say(
                f"finite elements: {1e3 * away:.4g} mm from the target, "
                f"{away / task.target.diagonal:.2%} of its diagonal"
            )
        say(one_line(report))
    return 0


def _tell_failure(tried: Tried) -> None:
    if tried.failure:
        tell(f"bilayer: {tried.failure}")
