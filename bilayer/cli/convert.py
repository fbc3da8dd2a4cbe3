"""The verb `convert`: the shapes of a result in the formats of other programs."""

import argparse
from functools import partial
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.cli.fields import result_fields
from bilayer.cli.outputs import Check, check_output
from bilayer.cli.parser import add_trust_argument, add_verb
from bilayer.errors import InputError
from bilayer.exports.conversion import (
    check_shape_output,
    convert,
    convert_milestones,
    milestone_names,
)
from bilayer.exports.frame import FRAMES, IN_MM, UNITS, Axes, usual_unit
from bilayer.exports.series import SERIES, convert_series, series_names
from bilayer.exports.solid import SOLIDS, check_solid_output, convert_solid
from bilayer.mesh.formats import WITH_LAYERS
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.runtime.output_file import check_writable
from bilayer.runtime.terminal import one_line, say, tell

RESULT = ".nc"


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "convert",
        "bilayer convert result.nc -o shape.vtu",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "-o", "--output", required=True,
        help="file; its ending selects one of meshio's formats, .nc the result with its fields",
    )  # fmt: skip
    which = verb.add_mutually_exclusive_group()
    which.add_argument(
        "--prestretch", type=float, metavar="L",
        help="the milestone to write (default: the last one reached)",
    )  # fmt: skip
    which.add_argument(
        "--all", action="store_true",
        help=f"every milestone reached: shape_1.03.vtu, ...; a {' or '.join(SERIES)} is one time "
        "series of them",
    )  # fmt: skip
    verb.add_argument(
        "--solid", action="store_true",
        help=f"the body with its thickness as a closed surface ({' '.join(SOLIDS)})",
    )  # fmt: skip
    verb.add_argument(
        "--part", choices=["midsurface", "volume"], default="midsurface",
        help="which body: the reference surface, or the layers (default: midsurface)",
    )  # fmt: skip
    verb.add_argument(
        "--fields", action="store_true", help="with strains, stresses, curvatures (docs/fields.md)"
    )
    verb.add_argument(
        "--unit", choices=list(UNITS),
        help=f"of lengths (default: m; mm of a solid and in {' '.join(IN_MM)})",
    )  # fmt: skip
    verb.add_argument(
        "--frame", choices=FRAMES,
        help="result: places as in it; body: each shape apex up in its own frame, the default of "
        "a series and of a solid",
    )  # fmt: skip
    add_trust_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    ending = Path(options.output).suffix.lower()
    if options.solid and (options.all or options.fields or options.frame == "result"):
        raise InputError(
            "--solid: one shape in its body frame, expected no --all, --fields, --frame"
        )
    check_output(options, _check_of(ending, options))
    result = open_result(options.result)
    if not result["converged"].values.any():
        raise InputError(f"result file {options.result}: has no milestone that was reached")
    if options.solid:
        convert_solid(result, options.output, options.prestretch, unit=options.unit or "mm")
    elif ending == RESULT:
        _write_fields(result, options)
    elif ending in SERIES:
        _write_series(result, options)
    else:
        _write_shapes(result, options)
    return 0


def _check_of(ending: str, options: argparse.Namespace) -> Check:
    """Return the check of an output, by its ending."""
    if options.solid:
        return check_solid_output
    if ending in SERIES:
        return check_writable
    return check_result_output if ending == RESULT else _check_of_shape(options)


def _check_of_shape(options: argparse.Namespace) -> Check:
    return partial(check_shape_output, part=options.part)


def _write_series(result: xr.Dataset, options: argparse.Namespace) -> None:
    """Write all milestones as a time series; the file is named, its shapes are beside it."""
    if options.prestretch is not None:
        raise InputError(f"--output {options.output}: all milestones, expected no --prestretch")
    check_output(options, check_writable, series_names(result, options.output))
    axes = Axes(options.frame or "body", options.unit or "m")
    fields = result_fields(result, options) if options.fields else None
    convert_series(result, options.output, options.part, fields=fields, axes=axes)


def _write_shapes(result: xr.Dataset, options: argparse.Namespace) -> None:
    axes = Axes(options.frame or "result", options.unit or usual_unit(options.output))
    if options.all:
        check_output(options, _check_of_shape(options), milestone_names(result, options.output))
    fields = result_fields(result, options) if options.fields else None
    given: dict[str, Any] = {"fields": fields, "axes": axes}
    if options.all:
        for path in convert_milestones(result, options.output, options.part, **given):
            say(one_line(path))
    else:
        convert(result, options.output, options.prestretch, options.part, **given)
    _tell_what_is_left_out(options)


def _write_fields(result: xr.Dataset, options: argparse.Namespace) -> None:
    """Write the result with its fields as a result."""
    if not options.fields or options.all or options.prestretch is not None:
        raise InputError(
            f"--output {options.output}: a result with all of its milestones, expected --fields "
            "and neither --all nor --prestretch"
        )
    write_result(result.merge(result_fields(result, options), compat="override"), options.output)


def _tell_what_is_left_out(options: argparse.Namespace) -> None:
    """Say so if the format holds no numbers beside the shape."""
    ending = Path(options.output).suffix.lower()
    if ending not in WITH_LAYERS and not options.quiet:
        left_out = "which layers lie where" if options.part == "midsurface" else "the layers"
        left_out += " and the fields" if options.fields else ""
        tell(
            f"bilayer: {options.output}: {ending} holds the shape without {left_out}; "
            f"{', '.join(WITH_LAYERS)} hold both"
        )
