"""The verb `plot`: the shapes of a result as a picture."""

import argparse
from typing import Any

from bilayer.cli.fields import add_field_argument, scalar_fields
from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.errors import InputError
from bilayer.results.files import open_result
from bilayer.results.milestones import choose_milestones


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "plot",
        "bilayer plot fenics.nc -o shape.png\n"
        "  bilayer plot fenics.nc --prestretch 1.06 1.24 --view front 30,20 -o shape.pdf",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "--prestretch", nargs="+", metavar="L",
        help="the milestones that are drawn (default: all)",
    )  # fmt: skip
    verb.add_argument(
        "--view", nargs="+", metavar="V", default=["isometric", "above"],
        help="isometric, above, front, or azimuth and elevation of the eye in degrees as '30,20' "
        "(default: isometric above)",
    )  # fmt: skip
    verb.add_argument(
        "-o", "--output", required=True, metavar="FIGURE", help="the picture: .png, .pdf, .svg, ..."
    )
    add_field_argument(verb, "colour the shapes by a field")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.figures import draw_shapes, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output

    check_output(options, check_figure_output)
    if len(options.field) > 1:
        raise InputError(f"--field: {len(options.field)} are given, expected one")
    result = open_result(options.result)
    if options.prestretch is not None:
        milestones = [number("--prestretch", word) for word in options.prestretch]
        result = choose_milestones(result, milestones)
    views = [view_argument(word) for word in options.view]
    field = next(iter(scalar_fields(result, options.field, options)), None)
    save_figure(draw_shapes(result, views=views, field=field), options.output)
    return 0


def view_argument(word: str) -> Any:
    """Return the name of a view, or its two angles in degrees."""
    return tuple(number("--view", part) for part in word.split(",")) if "," in word else word


def number(name: str, word: str) -> float:
    """Read a number of an option."""
    try:
        return float(word)
    except ValueError:
        raise InputError(f"{name} {word}: expected a number") from None
