"""The verb `compare`: two results beside one another, or a result and a scan of the part."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import xarray as xr

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_json_argument, add_trust_argument, add_verb
from bilayer.errors import InputError
from bilayer.mesh.formats import WITH_LAYERS
from bilayer.results.comparison import compare, comparison_table
from bilayer.results.files import open_result
from bilayer.results.milestones import along_milestones
from bilayer.results.records import comparison_record
from bilayer.runtime.terminal import say, say_json, warn
from bilayer.specimen.units import in_si

if TYPE_CHECKING:
    from bilayer.scan.cloud import Cloud
    from bilayer.scan.comparison import ScanMatch
    from bilayer.scan.profile import ProfileMatch
    from bilayer.solvers.scan_fit import ScanFit, Target

RESULT = ".nc"
MAPS = WITH_LAYERS
"""Endings of the meshes that hold the distance of a scan as a field."""


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "compare",
        "bilayer compare fenics.nc shell.nc -o comparison.png",
    )  # fmt: skip
    verb.add_argument("result", metavar="FILE.nc", help="a result")
    verb.add_argument(
        "other", metavar="OTHER", help="another result (.nc), or a scan (.stl .ply .obj .csv ...)"
    )
    verb.add_argument("--unit", default="mm", help="of a scan's coordinates (default: mm)")
    verb.add_argument(
        "--fit", metavar="PARAMETER",
        help="also find the value with which the shape fits a scan best: prestretch, "
        "substrate.thickness, kirigami.material.c10, ...",
    )  # fmt: skip
    verb.add_argument(
        "--profile", action="store_true",
        help="the scan is a profile: a table of the upper edge seen from the side, right and up",
    )  # fmt: skip
    add_trust_argument(verb)
    verb.add_argument(
        "-o", "--output", metavar="FIGURE",
        help=f"also draw the comparison; of a scan {' '.join(MAPS)} write its distance as a field",
    )  # fmt: skip
    add_json_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    from bilayer.exports.conversion import check_shape_output
    from bilayer.figures import draw_comparison, save_figure  # matplotlib takes half a second
    from bilayer.figures.saving import check_figure_output

    check_output(options, check_shape_output if _is_map(options) else check_figure_output)
    _check_order(options)
    if options.profile:
        return _compare_profile(options)
    if Path(options.other).suffix.lower() != RESULT:
        return _compare_scan(options)
    if options.fit is not None:
        raise InputError(f"--fit {options.fit}: fits a scan, expected no second result")
    first, second = (open_result(path) for path in (options.result, options.other))
    comparison = compare(first, second)
    if comparison.attrs["first"] == comparison.attrs["second"]:  # the files tell them apart
        for side, path in zip(("first", "second"), (options.result, options.other), strict=True):
            comparison.attrs[side] += f" ({Path(path).name})"
    if options.json:
        say_json(comparison_record(comparison))
    elif not options.quiet:
        say(comparison_table(comparison))
    if options.output is not None:
        save_figure(draw_comparison(comparison), options.output)
    return 0


def _is_map(options: argparse.Namespace) -> bool:
    """Whether the distance of a scan is to be written as a field."""
    of_scan = Path(options.other).suffix.lower() != RESULT and not options.profile
    return of_scan and Path(options.output or "").suffix.lower() in MAPS


def _check_order(options: argparse.Namespace) -> None:
    from bilayer.scan.cloud import MESHES, TABLES

    first, second = (Path(path).suffix.lower() for path in (options.result, options.other))
    if second == RESULT and first in (*MESHES, *TABLES):
        raise InputError(
            f"{options.result} {options.other}: expected the result first, then the scan"
        )
    if not options.profile and second not in (RESULT, *MESHES, *TABLES):
        raise InputError(
            f"{options.other}: expected a result ({RESULT}) or a scan "
            f"({', '.join((*MESHES, *TABLES))})"
        )


def _compare_profile(options: argparse.Namespace) -> int:
    from bilayer.figures.saving import save_figure  # matplotlib takes half a second
    from bilayer.figures.scan import draw_profile
    from bilayer.scan.comparison import best_match
    from bilayer.scan.profile import (
        compare_profile,
        profile_record,
        profile_table,
        read_profile,
    )
    from bilayer.solvers.scan_fit import scan_fit_report

    result, profile = open_result(options.result), read_profile(options.other, _unit(options))
    matches = compare_profile(result, profile)
    best, record, text = (
        matches[best_match(matches)],
        profile_record(matches),
        profile_table(matches),
    )
    if options.fit is not None:
        found = _fit(options, result, profile, record)
        best = cast("ProfileMatch", found.match)
        text += f"\n\n{scan_fit_report(found)}"
    _tell(options, record, text)
    if options.output is not None:
        save_figure(draw_profile(profile, best), options.output)
    return 0


def _fit(
    options: argparse.Namespace, result: xr.Dataset, target: "Target", record: dict[str, Any]
) -> "ScanFit":
    """Return the fit of the parameter that is asked for, which the record tells, too."""
    from bilayer.solvers.scan_fit import fit_to_scan

    found = fit_to_scan(result, target, options.fit, trust=options.trust)
    record["fit"] = {"parameter": found.parameter, "value": found.value, "rms": found.match.rms}
    return found


def _unit(options: argparse.Namespace) -> float:
    """Return one unit of a scan's coordinates, m."""
    return float(in_si("--unit", {"unit": f"1 {options.unit}"}, {"unit": "m"})["unit"])


def _tell(options: argparse.Namespace, record: dict[str, Any], text: str) -> None:
    if options.json:
        say_json(record)
    elif not options.quiet:
        say(text)


def _compare_scan(options: argparse.Namespace) -> int:
    from bilayer.scan.cloud import read_cloud
    from bilayer.scan.comparison import (
        best_match,
        compare_scan,
        scan_record,
        scan_table,
        size_doubt,
        ways_table,
    )
    from bilayer.solvers.scan_fit import scan_fit_report

    result, cloud = open_result(options.result), read_cloud(options.other, _unit(options))
    doubt = size_doubt(result, cloud)
    if doubt:
        warn(doubt)
    matches = compare_scan(result, cloud)
    record: dict[str, Any] = scan_record(matches)
    text = f"{scan_table(matches)}\n\n{ways_table(matches[best_match(matches)])}"
    if options.fit is not None:
        found = _fit(options, result, cloud, record)
        result, matches = found.result, [cast("ScanMatch", found.match)]
        text += f"\n\n{scan_fit_report(found)}"
    _tell(options, record, text)
    if options.output is not None:
        _write_scan(options, result, cloud, matches)
    return 0


def _write_scan(
    options: argparse.Namespace, result: xr.Dataset, cloud: "Cloud", matches: "list[ScanMatch]"
) -> None:
    """Write where the scan is away from the shape that fits best, as a figure or as a field."""
    from bilayer.exports.conversion import write_shape
    from bilayer.figures.saving import save_figure  # matplotlib takes half a second
    from bilayer.figures.scan import draw_scan
    from bilayer.scan.comparison import best_match
    from bilayer.scan.field import distance_to_scan

    best = matches[best_match(matches)]
    if not _is_map(options):
        save_figure(draw_scan(cloud, best), options.output)
        return
    fields = distance_to_scan(result, cloud, matches)
    whole = along_milestones(result)
    write_shape(whole, options.output, best.milestone, "midsurface", fields, axes=None)
