"""The verb `fit`: the constants of a law from tests of a material."""

import argparse
from typing import Any

from bilayer.cli.outputs import check_output
from bilayer.cli.parser import add_json_argument, add_verb
from bilayer.errors import BilayerError, InputError
from bilayer.fitting.fit import Fit, fit
from bilayer.fitting.laws import FITTED
from bilayer.fitting.measurement import Measurement, read_measurement
from bilayer.fitting.report import comparison_table, fit_record, fit_report
from bilayer.runtime.terminal import say, say_json
from bilayer.specimen.layer import layer_name
from bilayer.specimen.materials.stability import LOADINGS
from bilayer.specimen.units import in_si
from bilayer.validation import positive

ALL = "all"


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "fit",
        "bilayer fit tensile.csv --law mooney-rivlin -o fit.png",
    )  # fmt: skip
    verb.add_argument("tests", nargs="*", metavar="FILE.csv", help="uniaxial tests")
    for loading in LOADINGS:
        verb.add_argument(
            f"--{loading}", action="append", default=[], metavar="FILE.csv",
            help=f"a test under {loading} tension; may be repeated",
        )  # fmt: skip
    verb.add_argument(
        "--law", choices=[*FITTED, ALL], default="mooney-rivlin",
        help="which law (default: mooney-rivlin); 'all' compares them",
    )  # fmt: skip
    verb.add_argument("--up-to", type=float, metavar="L", help="leave out larger stretches")
    verb.add_argument(
        "--no-bounds", action="store_true", help="let the constants leave the range of stable laws"
    )
    verb.add_argument(
        "--poisson-ratio",
        type=float,
        default=0.5,
        metavar="NU",
        help="gives d1 (default: 0.5, incompressible)",
    )
    verb.add_argument(
        "--stretch-column", metavar="NAME",
        help="the column of stretches or strains, if no name of a column has such a word; with %% "
        "in its name it is a strain in per cent",
    )  # fmt: skip
    verb.add_argument(
        "--stress-column", metavar="NAME",
        help="the column of nominal stresses, its unit at the end, as in 'sigma (kPa)'",
    )  # fmt: skip
    verb.add_argument("--name", default="fitted", help="of the material in the printed table")
    verb.add_argument(
        "--relaxation", metavar="FILE.csv",
        help="a relaxation test, stress over time: its Prony series instead of a law",
    )  # fmt: skip
    verb.add_argument("--terms", type=int, metavar="N", help="of it (default: as AICc says)")
    verb.add_argument(
        "--ramp", default="0 s", metavar="T", help="time in which its stretch was reached"
    )
    verb.add_argument("--time-column", metavar="NAME", help="where its name does not say it")
    verb.add_argument("-o", "--output", metavar="FILE.png", help="draw the fit")
    add_json_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    if options.output is not None:
        from bilayer.figures.saving import check_figure_output  # matplotlib takes half a second

        check_output(options, check_figure_output)
    name = layer_name("--name", options.name)
    if options.relaxation is not None:
        return _fit_relaxation(options, name)
    measurements = _measurements(options)
    if options.law == ALL:
        fits = _fits(measurements, options)
        best = min(fits, key=lambda found: found.aicc)
    else:
        best = _fit(measurements, options.law, options, not options.no_bounds)
        fits = [best]
    _show(fits, best, measurements, options, name)
    if options.output is not None:
        from bilayer.figures import save_figure  # matplotlib takes half a second
        from bilayer.figures.fit import draw_fits

        save_figure(draw_fits(fits), options.output)
    return 0


def _fit_relaxation(options: argparse.Namespace, name: str) -> int:
    """Fit a Prony series; return the exit status."""
    from bilayer.fitting.relaxation import (
        fit_relaxation,
        read_relaxation,
        relaxation_record,
        relaxation_report,
    )

    if options.tests or any(getattr(options, loading) for loading in LOADINGS):
        raise InputError("--relaxation: a test of its own, expected no other tests beside it")
    ramp = in_si("--ramp", {"ramp": _time(options.ramp)}, {"ramp": "s"})["ramp"]
    test = read_relaxation(options.relaxation, options.time_column, options.stress_column)
    found = fit_relaxation(test, options.terms, ramp)
    if options.json:
        say_json(relaxation_record(found))
    else:
        say(relaxation_report(found, name))
    if options.output is not None:
        from bilayer.figures import save_figure  # matplotlib takes half a second
        from bilayer.figures.relaxation import draw_relaxation

        save_figure(draw_relaxation(found), options.output)
    return 0


def _time(word: str) -> Any:
    """Return a number of seconds, or a text with a unit."""
    try:
        return float(word)
    except ValueError:
        return word


def _show(
    fits: list[Fit],
    best: Fit,
    measurements: list[Measurement],
    options: argparse.Namespace,
    name: str,
) -> None:
    """Print the best fit, after the table of all if there are several."""
    if options.json:
        say_json([fit_record(found) for found in sorted(fits, key=lambda found: found.aicc)])
        return
    if options.law == ALL:
        say(comparison_table(fits), end="\n\n")
    free = None if options.no_bounds else _fit(measurements, best.law_name, options, False)
    say(fit_report(best, free, name))


def _measurements(options: argparse.Namespace) -> list[Measurement]:
    files = {loading: list(getattr(options, loading)) for loading in LOADINGS}
    files["uniaxial"] = [*options.tests, *files["uniaxial"]]
    read = [
        read_measurement(path, loading, options.stretch_column, options.stress_column)
        for loading, paths in files.items()
        for path in paths
    ]
    if not read:
        raise InputError("expected at least one file of a test")
    if options.up_to is not None:
        largest = positive("--up-to", options.up_to)
        read = [measurement.up_to(largest) for measurement in read]
    return read


def _fits(measurements: list[Measurement], options: argparse.Namespace) -> list[Fit]:
    """Return the fits of all laws but those that cannot be fitted."""
    found = []
    failed: BilayerError | None = None
    for law in FITTED:
        try:
            found.append(_fit(measurements, law, options, not options.no_bounds))
        except BilayerError as error:
            failed = error
    if not found and failed is not None:
        raise failed
    return found


def _fit(
    measurements: list[Measurement], law: str, options: argparse.Namespace, bounded: bool
) -> Fit:
    return fit(measurements, law, options.poisson_ratio, bounded)
