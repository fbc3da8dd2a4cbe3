"""The verb `init`: a specimen file to begin with."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.runtime.terminal import say
from bilayer.specimen.toml import template


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "init",
        "bilayer init -o specimen.toml",
    )  # fmt: skip
    verb.add_argument("-o", "--output", help="a new file (left out: it is printed)")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    check_output(options, check_writable)
    if options.output is None:
        say(template(), end="")
        return 0
    if Path(options.output).exists():
        raise InputError(
            f"output file {options.output}: is there already, expected the name of a new file"
        )
    with whole_file(options.output, "specimen file") as partial:
        partial.write_text(template(), "utf-8")
    return 0
