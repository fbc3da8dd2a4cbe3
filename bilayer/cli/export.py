"""The verb `export`: a specimen as input decks for CalculiX, in Abaqus' keywords."""

import argparse
from typing import Any

from bilayer.calculix.deck import DeckSettings, check_deck_output, deck_names, write_decks
from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.cli.specimen_arguments import (
    add_case_arguments,
    add_specimen_arguments,
    read_mesh_argument,
    read_specimen_argument,
)
from bilayer.runtime.terminal import one_line, say
from bilayer.specimen.settings import describe, settings_from, split_solver_settings


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "export",
        "bilayer export specimen.toml -o deck.inp --prestretch 1.06\n  ccx deck\n"
        "  bilayer import deck.frd specimen.toml --prestretch 1.06 -o ccx.nc",
    )  # fmt: skip
    add_specimen_arguments(verb)
    add_case_arguments(verb)
    verb.add_argument(
        "-o", "--output", required=True, metavar="FILE.inp",
        help="the deck; several become deck_1.03.inp, deck_1.06.inp, ...",
    )  # fmt: skip
    verb.late_epilog = lambda: (
        f"settings, changed by --set solver.NAME=VALUE:\n{describe(DeckSettings)}"
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    values, overrides = split_solver_settings(options.overrides)
    specimen = read_specimen_argument(options, overrides)
    settings = settings_from(DeckSettings, values)
    check_output(options, check_deck_output, deck_names(specimen, options.output))
    for path in write_decks(
        specimen, read_mesh_argument(options, specimen), options.output, settings
    ):
        if not options.quiet:
            say(one_line(path))
    return 0
