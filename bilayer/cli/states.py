"""The verb `states`: the stable shapes of a specimen at one prestretch."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_json_argument, add_verb
from bilayer.cli.specimen_arguments import (
    add_specimen_arguments,
    read_mesh_argument,
    read_specimen_argument,
)
from bilayer.landscape.confirm import confirm
from bilayer.landscape.report import describe_search, states_table
from bilayer.landscape.search import STARTS, states
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.results.records import result_record
from bilayer.results.report import law_warnings
from bilayer.runtime.output_file import remove_leftovers
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.ranks import is_first_rank
from bilayer.runtime.terminal import say, say_json
from bilayer.solvers.registry import SOLVERS, settings_class
from bilayer.specimen.settings import settings_from, split_solver_settings


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "states",
        "bilayer states specimen.toml --prestretch 1.15 -o states.nc\n"
        "  bilayer plot states.nc -o states.png",
    )  # fmt: skip
    add_specimen_arguments(verb)
    verb.add_argument(
        "--prestretch", metavar="L",
        help="where to look, L or LX,LY; the file's last milestone if left out",
    )  # fmt: skip
    verb.add_argument("--mesh", metavar="FILE", help="use this planar mesh, or that of a result")
    verb.add_argument("-o", "--output", metavar="FILE.nc", help="file of the states, a result")
    verb.add_argument(
        "--starts", type=int, default=STARTS, metavar="N", help=f"starts, {STARTS} if left out"
    )
    verb.add_argument(
        "--start", metavar="FILE.nc",
        help="a result, such as states on another mesh: its shapes are the first starts",
    )  # fmt: skip
    verb.add_argument("--model", help="of the shell: morley, the default, or hinge")
    verb.add_argument(
        "--resume", action="store_true",
        help="go on from FILE.nc if it is there, or look longer with more starts",
    )  # fmt: skip
    verb.add_argument(
        "--confirm", choices=[name for name in SOLVERS if name != "dshell"],
        help="start this solver from each state, and say whether it has it, too",
    )  # fmt: skip
    add_json_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    if not is_first_rank():
        return 0
    check_output(options, check_result_output)
    values, overrides = split_solver_settings(options.overrides)
    options.prestretch = None if options.prestretch is None else [options.prestretch]
    specimen = read_specimen_argument(options, overrides)
    settings: Any = settings_from(settings_class("dshell", options.model), values)
    output = None if options.output is None else Path(options.output)
    resume = output if options.resume and output is not None and output.exists() else None
    if resume is not None:
        remove_leftovers(resume)
    with progress_bar("states", shown=not options.quiet) as progress:
        found = states(
            specimen,
            settings,
            starts=options.starts,
            mesh=None if options.mesh is None else read_mesh_argument(options, specimen),
            start=None if options.start is None else open_result(options.start),
            progress=progress,
            output=output,
            resume=resume,
        )
    if options.confirm is not None:
        with progress_bar(options.confirm, shown=not options.quiet) as progress:
            found = confirm(found, options.confirm, progress=progress)
        if output is not None:
            write_result(found, output)
    if options.json:
        say_json({**result_record(found), "search": describe_search(found)})
    elif not options.quiet:
        say("\n".join([states_table(found), describe_search(found), *law_warnings(found)]))
    return 0
