"""The verb `convert`: the shapes of a result in the formats of other programs."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.mesh.files import check_mesh_output
from bilayer.mesh.planar_files import WITH_LAYERS
from bilayer.results.conversion import convert, convert_milestones, milestone_names
from bilayer.results.files import open_result
from bilayer.runtime.terminal import one_line, say, tell


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "convert",
        "bilayer convert result.nc -o shape.vtu",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "-o", "--output", required=True, help="file; its ending selects one of meshio's formats"
    )
    which = verb.add_mutually_exclusive_group()
    which.add_argument(
        "--prestretch", type=float, metavar="L",
        help="the milestone to write (default: the last one reached)",
    )  # fmt: skip
    which.add_argument(
        "--all", action="store_true", help="every milestone reached: shape_1.03.vtu, ..."
    )
    verb.add_argument(
        "--part", choices=["midsurface", "volume"], default="midsurface",
        help="which body: the reference surface, or the volume of a finite-element result "
        "(default: midsurface)",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    check_output(options, check_mesh_output)
    result = open_result(options.result)
    if not result["converged"].values.any():
        raise InputError(f"result file {options.result}: has no milestone that was reached")
    if options.all:
        check_output(options, check_mesh_output, milestone_names(result, options.output))
        for path in convert_milestones(result, options.output, options.part):
            say(one_line(path))
    else:
        convert(result, options.output, options.prestretch, options.part)
    _tell_what_is_left_out(options)
    return 0


def _tell_what_is_left_out(options: argparse.Namespace) -> None:
    """Say so if the format holds no numbers beside the shape."""
    ending = Path(options.output).suffix.lower()
    if ending not in WITH_LAYERS and not options.quiet:
        left_out = "which layers lie where" if options.part == "midsurface" else "the layers"
        tell(
            f"bilayer: {options.output}: {ending} holds the shape without {left_out}; "
            f"{', '.join(WITH_LAYERS)} hold both"
        )
