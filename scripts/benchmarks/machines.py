"""Two machines, or one machine at two times, by the files that `scripts/benchmark compare` keeps.

Nothing is computed. A case is in the table if both files have it; its costs are those of the newer
revision in each file, its numbers say whether both machines found the same.
"""

import argparse
import json
import statistics
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from benchmarks.compared_cases import CASES
from benchmarks.page import table_text
from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text

DESCRIPTION = "two files of results/benchmarks: CPU time, memory, and how far results are apart"
EXAMPLES = """\
  scripts/benchmark machines results/benchmarks/amd-epyc-2-cores.json other.json
"""
QUANTITIES = {"CPU s": "cpu", "GB": "gigabytes"}
Cases = Mapping[str, dict[str, Any]]


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the two files."""
    parser.add_argument("first", metavar="FIRST.json", help="of one machine")
    parser.add_argument("second", metavar="SECOND.json", help="of another, or of a later time")


def tables(options: argparse.Namespace) -> Iterator[str]:
    """Yield what differs between the machines, then the table of the cases that both have."""
    if options.write:
        raise InputError("--write: the page has no part for two files, expected none")
    first, second = (_read(path) for path in (options.first, options.second))
    yield _machines(first["machine"], second["machine"])
    yield comparison(_cases(first), _cases(second))


def _read(path: str) -> dict[str, Any]:
    """Return what a file holds; raise InputError if it is none of `scripts/benchmark compare`."""
    try:
        document = json.loads(read_text(path, "benchmark file"))
    except ValueError as error:
        raise InputError(f"benchmark file {path}: not valid JSON ({error})") from error
    if not isinstance(document, dict) or not {"machine", "comparisons"} <= set(document):
        raise InputError(f"benchmark file {path}: expected the keys machine and comparisons")
    return document


def _cases(document: Mapping[str, Any]) -> Cases:
    """Return the newest comparison of each case."""
    return {one["case"]: one for one in document["comparisons"] if one["case"] in CASES}


def _machines(first: Mapping[str, Any], second: Mapping[str, Any]) -> str:
    """Return what the costs depend on, of both machines; what is equal once."""
    keys = dict.fromkeys([*first, *second])
    lines = [
        f"{key:10} {first.get(key)}"
        + ("" if first.get(key) == second.get(key) else f"  |  {second.get(key)}")
        for key in keys
    ]
    return "\n".join(lines)


def comparison(first: Cases, second: Cases) -> str:
    """Return the cases that both have as text, a row each."""
    rows = [
        _row(name, first[name], second[name]) for name in CASES if {name} <= {*first} & {*second}
    ]
    if not rows:
        raise InputError("the files have no case in common, expected one at least")
    return table_text(rows)


def _row(name: str, first: dict[str, Any], second: dict[str, Any]) -> dict[str, str]:
    row = {"what": CASES[name].text, "revisions": f"{first['revision']} {second['revision']}"}
    for title, quantity in QUANTITIES.items():
        one, other = (
            statistics.median(cost[quantity] for cost in case["now"]) for case in (first, second)
        )
        row[title] = f"{one:.2f} {other:.2f}"
        row[f"{title} ratio"] = f"{other / one:.2f}"
    return row | {"apart": _apart(first["now"][0]["numbers"], second["now"][0]["numbers"])}


def _apart(first: list[float], second: list[float]) -> str:
    """Return the largest relative difference of the numbers of a result; "" without numbers."""
    one, other = np.array(first), np.array(second)
    if len(one) != len(other):
        return "other numbers"
    if len(one) == 0:
        return ""
    return f"{(np.abs(other - one) / np.where(one == 0, 1.0, np.abs(one))).max():.0e}"
