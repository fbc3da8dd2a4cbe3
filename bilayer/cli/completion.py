"""Completion of the command line by the Tab key, if the package argcomplete is installed.

The shell starts `bilayer` with the line so far in its environment; docs/usage.md says how it is
switched on. Nothing is computed then.
"""

import os
import shlex
from collections.abc import Sequence

from bilayer.cli.parser import Parser


def words_to_complete() -> Sequence[str] | None:
    """Return the words after `bilayer` that a shell asks to complete; None if none asks."""
    if "_ARGCOMPLETE" not in os.environ:
        return None
    line = os.environ.get("COMP_LINE", "")[: int(os.environ.get("COMP_POINT", "0") or 0)]
    try:
        return shlex.split(line)[1:]
    except ValueError:  # within a quotation
        return line.split()[1:]


def complete_words(parser: Parser) -> int:
    """Tell the shell how the word at the cursor may go on; return the exit status."""
    try:
        import argcomplete
    except ImportError:
        return 1  # the shell offers files
    argcomplete.autocomplete(parser, always_complete_options=False)
    return 1
