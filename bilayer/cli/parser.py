"""Parsing the words of a verb: its options, those that all verbs share, and its errors."""

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import PurePath
from typing import Any, NoReturn

from bilayer.cli.verbs import VERBS
from bilayer.runtime.terminal import flush_stdout, say, tell
from bilayer.validation import nearest


class Parser(argparse.ArgumentParser):
    """A parser whose errors are one line, and whose epilog may be computed when it is asked for."""

    late_epilog: Callable[[], str] | None = None

    def __init__(self, **options: Any) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **options)

    def error(self, message: str) -> NoReturn:
        """End with exit status 2 and one line on stderr."""
        self.exit(2, f"{self.prog}: error: {message}; see {self.prog} --help\n")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Raise ArgumentError, with the nearest choice, unless a word is one of the choices."""
        if action.choices is not None and value not in action.choices:
            choices = list(map(str, action.choices))
            near = _verb_of_file(value) if choices == [*VERBS] else ""
            expected = f"expected one of {', '.join(choices)}{near or nearest(value, choices)}"
            raise argparse.ArgumentError(action, f"invalid choice: {value!r}, {expected}")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:  # type: ignore[override]
        """Parse; for an option that is not known, the error names the nearest one."""
        known, rest = super().parse_known_args(args, namespace)
        self._check_words(vars(known))
        unknown = [word for word in rest if word.startswith("-")]
        if unknown:
            options = list(self._option_string_actions)
            name = unknown[0].partition("=")[0]
            self.error(f"unknown option {name}{nearest(name, options)}")
        if rest:
            self._refuse_further_words(vars(known), rest)
        return known, rest

    def _refuse_further_words(self, values: Mapping[str, Any], rest: list[str]) -> NoReturn:
        """End with an error that says what was taken, and which words are too many."""
        taken = [
            f"{action.dest} = {given}"
            for action in self._actions
            if not action.option_strings and isinstance(given := values.get(action.dest), str)
        ]
        after = f" after {', '.join(taken)}" if taken else ""
        self.error(f"{' '.join(rest)}: expected options alone{after}")

    def _check_words(self, values: Mapping[str, Any]) -> None:
        """End with an error if a word is empty, or holds what no name of a file can hold."""
        for action in self._actions:
            given = values.get(action.dest)
            for word in given if isinstance(given, list) else [given]:
                if isinstance(word, str) and (not word.strip() or "\0" in word):
                    name = "/".join(action.option_strings) or action.metavar or action.dest
                    self.error(f"argument {name}: {word!r}: expected a word, not an empty one")

    def _print_message(self, message: str, file: Any = None) -> None:
        """Print a help text, the version or an error; argparse itself loses it on a full disk."""
        if file is sys.stdout:
            say(message, end="")
            flush_stdout()
        elif message:
            tell(message.removesuffix("\n"))

    def format_help(self) -> str:
        """Return the help text; the late epilog is computed now."""
        if self.late_epilog is not None:
            self.epilog = f"{self.epilog}\n\n{self.late_epilog()}"
            self.late_epilog = None
        return super().format_help()


def _verb_of_file(word: str) -> str:
    """Return how the command is called with a file that stands where a verb is expected, or ""."""
    verb = {".toml": "solve", ".nc": "info"}.get(PurePath(word).suffix.lower())
    return f"; did you mean 'bilayer {verb} {word}'?" if verb else ""


def add_trust_argument(verb: Parser) -> None:
    """Add the option by which the user vouches for a file."""
    verb.add_argument(
        "--trust", action="store_true",
        help="use also settings of the file that could run code or write files",
    )  # fmt: skip


def add_json_argument(verb: Parser) -> None:
    """Add the option by which a program asks for what a table shows."""
    verb.add_argument(
        "--json", action="store_true",
        help="print JSON instead of a table: numbers in SI units, null where there is none",
    )  # fmt: skip


def main_parser(**options: Any) -> Parser:
    """Return the parser of the command, with the options that may stand before a verb, too."""
    parser = Parser(**options)
    _add_options_of_all(parser, default=False)
    return parser


def add_verb(verbs: Any, run: Callable[[Any], int], name: str, example: str) -> Parser:
    """Add a verb with the options that all of them share; `run` is what it does."""
    text = VERBS[name]
    verb = verbs.add_parser(name, help=text, description=text, epilog=f"example:\n  {example}")
    _add_options_of_all(verb, default=argparse.SUPPRESS)  # else it takes back what came before
    verb.set_defaults(run=run)
    return verb


def _add_options_of_all(parser: Parser, default: Any) -> None:
    parser.add_argument(
        "--quiet", action="store_true", default=default, help="no progress, no table"
    )
    parser.add_argument(
        "--verbose", action="store_true", default=default, help="settings in use, traces of errors"
    )
