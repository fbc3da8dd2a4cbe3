"""The verb `init`: a specimen file to begin with."""

import argparse
from typing import Any

from bilayer.cli.parser import add_verb
from bilayer.runtime.terminal import say
from bilayer.specimen.toml import template


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    add_verb(
        verbs, run, "init",
        "bilayer init > specimen.toml",
    )  # fmt: skip


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    say(template(), end="")
    return 0
