"""The verb `view`: a page that shows a result in three dimensions."""

import argparse
import webbrowser
from pathlib import Path
from typing import Any

from bilayer.cli.fields import add_field_argument, scalar_fields
from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.results.files import open_result
from bilayer.runtime.output_file import check_writable
from bilayer.runtime.terminal import one_line, say


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "view",
        "bilayer view fenics.nc -o shape.html",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument("other", nargs="?", metavar="OTHER.nc", help="shown over the first")
    verb.add_argument(
        "-o", "--output", metavar="FILE.html", help="the page (default: FILE.html beside FILE.nc)"
    )
    add_field_argument(verb, "offer a field as colour (as often as wanted)")
    verb.add_argument("--no-open", action="store_true", help="write it, do not open a browser")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.viewer.page import view  # matplotlib's colours take half a second

    result = open_result(options.result)
    options.output = options.output or str(Path(options.result).with_suffix(".html"))
    check_output(options, check_writable)
    output = Path(options.output)
    if output.suffix.lower() not in (".html", ".htm"):
        raise InputError(f"page {output}: expected a name in .html")
    other = None if options.other is None else open_result(options.other)
    coloured = scalar_fields(result, options.field, options)
    view(result, other, Path(options.result).stem, coloured).save(output)
    if not options.quiet:
        say(one_line(output))
    if not options.no_open:
        webbrowser.open_new_tab(output.resolve().as_uri())
    return 0
