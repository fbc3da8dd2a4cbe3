"""The verb `import`: shapes that CalculiX computed from exported decks, as a result."""

import argparse
from typing import Any

from bilayer.calculix.result import import_calculix
from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.cli.specimen_arguments import (
    add_case_arguments,
    add_specimen_arguments,
    read_mesh_argument,
    read_specimen_argument,
)
from bilayer.results.files import check_result_output, write_result
from bilayer.results.report import result_table, table_warnings
from bilayer.runtime.terminal import say, tell


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "import",
        "bilayer import deck_1.03.frd deck_1.06.frd specimen.toml -o ccx.nc",
    )  # fmt: skip
    verb.add_argument(
        "frd", nargs="+", metavar="DECK.frd",
        help="one per prestretch; the .sta and .cvg files are read, too",
    )  # fmt: skip
    add_specimen_arguments(verb)
    add_case_arguments(verb)
    verb.add_argument("-o", "--output", required=True, metavar="FILE.nc", help="the result")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status, 1 if a deck stopped before its end."""
    check_output(options, check_result_output)
    specimen = read_specimen_argument(options, options.overrides)
    result = import_calculix(options.frd, specimen, read_mesh_argument(options, specimen))
    write_result(result, options.output)
    if not options.quiet:
        say("\n".join([result_table(result), *table_warnings(result)]))
    if bool(result["converged"].all()):
        return 0
    tell(f"bilayer: stopped early: {result.attrs['stop_reason']}")
    return 1
