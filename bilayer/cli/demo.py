"""The verb `demo`: a dome in one command, as a picture and as a page, and what to do next."""

import argparse
from pathlib import Path
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.results.files import check_result_output
from bilayer.results.report import result_table
from bilayer.runtime.output_file import check_writable, whole_file
from bilayer.runtime.progress import progress_bar
from bilayer.runtime.terminal import one_line, say
from bilayer.solvers.registry import solve
from bilayer.specimen.toml import parse_specimen, template

STEM = "dome"


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "demo",
        "bilayer demo",
    )  # fmt: skip
    verb.add_argument(
        "-o", "--output", metavar="STEM", default=STEM,
        help=f"name of the files that are written, without its ending (default: {STEM})",
    )  # fmt: skip
    verb.add_argument("--overwrite", action="store_true", help="replace files of these names")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures import draw_shapes, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output
    from bilayer.viewer.page import view

    checks = {
        ".toml": check_writable, ".nc": check_result_output, ".png": check_figure_output,
        ".html": check_writable,
    }  # fmt: skip
    files = {ending: Path(f"{options.output}{ending}") for ending in checks}
    for ending, check in checks.items():
        if files[ending].exists() and not options.overwrite:
            raise InputError(
                f"output file {files[ending]}: is there already, expected --overwrite to replace "
                "it or another name as -o STEM"
            )
        check_output(options, check, [files[ending]])
    text = template()
    with whole_file(files[".toml"], "specimen file") as file:
        file.write_text(text, encoding="utf-8")
    with progress_bar("dshell", shown=not options.quiet) as progress:
        result = solve(parse_specimen(text), "dshell", output=files[".nc"], progress=progress)
    save_figure(draw_shapes(result), files[".png"])
    view(result, title=files[".html"].stem).save(files[".html"])
    if not options.quiet:
        say(f"{result_table(result)}\n")
        say(_what_now(files))
    return 0


def _what_now(files: dict[str, Path]) -> str:
    toml, result, picture, page = (one_line(files[e]) for e in (".toml", ".nc", ".png", ".html"))
    return (
        f"{picture}    the dome at each prestretch\n"
        f"{page}   the same to turn and zoom: open it in a browser\n"
        f"{result}     the numbers: bilayer info {result}\n"
        f"{toml}   the sheet: edit it, then\n"
        f"  bilayer solve {toml} --plot --overwrite"
    )
