"""The verb `plot-study`: a quantity over a field of a study, as a picture."""

import argparse
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.specimen.overrides import toml_value
from bilayer.study.dataset import open_study


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "plot-study",
        "bilayer plot-study study --x cut.cutout_angle --y quality --hue cut.strips "
        "--prestretch 1.15 -o FIG.png",
    )  # fmt: skip
    verb.add_argument("study", metavar="DIR", help="the study's folder")
    verb.add_argument(
        "--x", required=True, metavar="FIELD",
        help="field on the horizontal axis (or 'prestretch')",
    )  # fmt: skip
    verb.add_argument(
        "--y", default="quality", metavar="SCALAR",
        help="quantity on the vertical axis (default: quality)",
    )  # fmt: skip
    verb.add_argument("--hue", metavar="FIELD", help="draw a line for each value of this field")
    verb.add_argument(
        "--as", dest="kind", choices=["lines", "panels", "map"], default="lines",
        help="lines in one panel (the default), a panel for each value of --hue, or a coloured "
        "cell for each pair of values",
    )  # fmt: skip
    verb.add_argument("--prestretch", metavar="L", help="draw this prestretch only")
    verb.add_argument(
        "--select", action="append", default=[], metavar="FIELD=VALUE",
        help="draw only the cases with this value",
    )  # fmt: skip
    verb.add_argument(
        "-o", "--output", required=True, metavar="FIGURE", help="the picture: .png, .pdf, .svg, ..."
    )


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures import save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output
    from bilayer.study.figure import draw_study

    check_output(options, check_figure_output)
    chosen = dict(_selection(word) for word in options.select)
    if options.prestretch is not None:
        chosen["prestretch"] = toml_value("--prestretch", options.prestretch)
    study = open_study(options.study)
    figure = draw_study(study, options.x, options.y, options.hue, chosen, kind=options.kind)
    save_figure(figure, options.output)
    return 0


def _selection(word: str) -> tuple[str, Any]:
    name, separator, value = word.partition("=")
    if not separator:
        raise InputError(f"--select {word}: expected FIELD=VALUE")
    return name.strip(), toml_value(f"--select {name.strip()}", value)
