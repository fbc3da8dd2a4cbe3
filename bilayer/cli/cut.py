"""The verb `cut`: the files that a cutter needs, one for each layer."""

import argparse
from dataclasses import replace
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_verb
from bilayer.cli.specimen_arguments import add_specimen_file, milestone_argument
from bilayer.cutting.files import (
    check_cut_ending,
    check_cut_output,
    cut_file_names,
    write_cut_files,
)
from bilayer.cutting.style import STYLES
from bilayer.drawings.source import hexadecimal
from bilayer.runtime.terminal import say, warn
from bilayer.specimen.toml import read_specimen
from bilayer.specimen.units import in_si

LENGTHS = {"kerf": "m", "least_web": "m"}


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "cut",
        "bilayer cut specimen.toml -o parts.dxf --kerf '0.2 mm'",
    )  # fmt: skip
    add_specimen_file(verb)
    verb.add_argument(
        "-o", "--output", required=True,
        help="file in .dxf, .svg or .pdf; with several layers the name of each is added to it",
    )  # fmt: skip
    verb.add_argument(
        "--layer", action="append", metavar="NAME", help="this layer alone; may be repeated"
    )
    verb.add_argument(
        "--prestretch", metavar="L",
        help="at which stretched layers are bonded (default: the last milestone); L, or LX,LY",
    )  # fmt: skip
    verb.add_argument("--kerf", default="0 mm", help="width of the cut (default: 0 mm)")
    verb.add_argument(
        "--least-web", default="1 mm", metavar="W",
        help="narrower webs and slots are named (default: 1 mm)",
    )  # fmt: skip
    verb.add_argument("--marks", action="store_true", help="add registration marks")
    verb.add_argument(
        "--style", choices=STYLES, default="plain",
        help="layer names and colours that a service or program asks for (default: plain)",
    )  # fmt: skip
    verb.add_argument("--layer-name", metavar="TEXT", help="name of the layer of the cuts")
    verb.add_argument("--colour", help="colour of the cuts, as 'red' or '#ff0000'")


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    specimen = read_specimen(options.specimen, options.overrides, notice=warn)
    check_cut_ending(options.output)
    layers = options.layer or specimen.layer_names
    check_output(options, check_cut_output, cut_file_names(options.output, layers))
    if options.prestretch is not None:
        specimen = specimen.with_milestones([milestone_argument(options.prestretch)])
    given = {"kerf": options.kerf, "least_web": options.least_web}
    style = STYLES[options.style]
    if options.layer_name is not None:
        style = replace(style, cut=options.layer_name)
    if options.colour is not None:
        style = replace(style, cut_colour=hexadecimal(options.colour))
    files = write_cut_files(
        specimen, options.output, options.layer, marks=options.marks, style=style,
        **in_si("cut", given, LENGTHS),
    )  # fmt: skip
    for file in files:
        if not options.quiet:
            say(file.words)
        for obstacle in file.obstacles:
            warn(f"{file.part.layer}: {obstacle}")
    return 0
