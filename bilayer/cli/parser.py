"""Parsing the words of a verb: its options, those that all verbs share, and its errors."""

import argparse
from collections.abc import Callable
from typing import Any, NoReturn

from bilayer.cli.verbs import VERBS


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and whose epilog may be computed when it is asked for."""

    late_epilog: Callable[[], str] | None = None

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """End with exit status 2 and one line on stderr."""
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")

    def format_help(self) -> str:
        """Return the help text; the late epilog is computed now."""
        if self.late_epilog is not None:
            self.epilog = f"{self.epilog}\n\n{self.late_epilog()}"
            self.late_epilog = None
        return super().format_help()


def add_trust_argument(verb: Parser) -> None:
    """Add the option by which the user vouches for a file."""
    verb.add_argument(
        "--trust", action="store_true",
        help="use also settings of the file that could run code or write files",
    )  # fmt: skip


def add_verb(verbs: Any, run: Callable[[Any], int], name: str, example: str) -> Parser:
    """Add a verb with the options that all of them share; `run` is what it does."""
    text = VERBS[name]
    verb = verbs.add_parser(name, help=text, description=text, epilog=f"example:\n  {example}")
    verb.add_argument("--quiet", action="store_true", help="no progress, no table")
    verb.add_argument("--verbose", action="store_true", help="settings in use, traces of errors")
    verb.set_defaults(run=run)
    return verb
