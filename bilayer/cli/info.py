"""The verb `info`: what a sheet is, or a result's provenance and how far it can be trusted."""

import argparse
import shlex
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.cli.parser import add_json_argument, add_verb
from bilayer.errors import InputError
from bilayer.results.files import open_result
from bilayer.results.records import result_record
from bilayer.results.report import provenance
from bilayer.results.schema import TIMES_FOUND
from bilayer.results.sheet_report import sheet_report
from bilayer.runtime.terminal import one_line, say, say_json
from bilayer.solvers.registry import SOLVERS
from bilayer.solvers.rerun import result_settings, solve_command
from bilayer.specimen.settings import check_plain
from bilayer.specimen.toml import read_specimen, specimen_to_toml

SPECIMEN = ".toml"


def add(verbs: Any) -> None:
    """Add the verb and its arguments to a parser's verbs."""
    verb = add_verb(
        verbs, run, "info",
        "bilayer info fenics.nc",
    )  # fmt: skip
    verb.add_argument("file", metavar="FILE", help="a result (.nc) or a specimen file (.toml)")
    verb.add_argument("--specimen", action="store_true", help="print only the specimen's TOML file")
    add_json_argument(verb)


def run(options: argparse.Namespace) -> int:
    """Do it; return the exit status."""
    if Path(options.file).suffix.lower() == SPECIMEN:
        return _tell_of_specimen(options)
    result = open_result(options.file)
    if options.specimen:
        say(result.attrs["specimen"], end="")
        return 0
    if options.json:
        say_json(result_record(result))
        return 0
    lines = [provenance(result)]
    if result.attrs["solver"] in SOLVERS:
        lines.append(_to_run_again(options.file, result))
    say("\n".join(lines))
    return 0


def _tell_of_specimen(options: argparse.Namespace) -> int:
    if options.json:
        raise InputError(f"--json: of a result, expected a .nc file, not {options.file}")
    specimen = read_specimen(options.file)
    say(specimen_to_toml(specimen) if options.specimen else sheet_report(specimen) + "\n", end="")
    return 0


def _to_run_again(path: str, result: xr.Dataset) -> str:
    file = one_line(shlex.quote(path))
    try:
        check_plain(result_settings(result))
        command = one_line(solve_command(result, path))
    except InputError as error:  # of another version, or more than settings
        return f"\nIt is not run again as it stands: {one_line(error)}"
    if TIMES_FOUND in result:
        return (
            "\nTo search again:\n"
            f"  bilayer info {file} --specimen > again.toml\n"
            f"  bilayer states again.toml --mesh {file} -o again.nc"
        )
    return (
        "\nTo run it again, with the versions above:\n"
        f"  bilayer rerun {file}\n"
        "or step by step:\n"
        f"  bilayer info {file} --specimen > again.toml\n"
        f"  {command}"
    )
