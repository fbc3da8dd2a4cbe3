"""The verb `info`: what made a result, and how far it can be trusted."""

import argparse
from typing import Any

from bilayer.report import provenance
from bilayer.result import open_result
from bilayer.verbs.parser import add_verb


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "info", "say what made a result, and how far it can be trusted",
        "bilayer info fenics.nc",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    print(provenance(open_result(options.result)))
    return 0
