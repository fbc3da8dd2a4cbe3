"""The plan of a study: its cases, all of them valid, read from a study file.

A field is named as on the command line: `cut.strips` of the specimen, and `settings.dshell.profile`
for a setting of one solver (`settings.dshell.model` for its model). Rows that differ in the
prestretch alone are one case: its milestones lie on one load path.
"""

import json
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text
from bilayer.runtime.terminal import Notice, keep_quiet
from bilayer.solvers.registry import SOLVERS, settings_class, solver_named
from bilayer.specimen.prestretch import MILESTONES_FIELD
from bilayer.specimen.settings import check_plain, settings_from
from bilayer.specimen.toml import parse_specimen_file
from bilayer.specimen.toml_text import parse_toml
from bilayer.study.case import Case
from bilayer.study.variation import (
    Row,
    check_count,
    named_fields,
    product_rows,
    sampled_rows,
    zipped_rows,
)
from bilayer.validation import nearest, one_of, shown

KEYS = ("specimen", "solver", "settings", "vary", "zip", "sample")
SOLVER_FIELD = "solver"
SECONDS_BETWEEN_NOTICES = 5.0


@dataclass(frozen=True)
class StudyPlan:
    """All cases of a study.

    Parameters
    ----------
    fields : tuple of str
        Dotted names of what varies from case to case, `solver` among them if it does.
    cases : tuple of Case
        Each once, in the order of the study file.
    """

    fields: tuple[str, ...]
    cases: tuple[Case, ...]


def read_study(path: str | Path, *, trust: bool = False, notice: Notice = keep_quiet) -> StudyPlan:
    """Read a study file; every case is checked.

    Parameters
    ----------
    path : path-like
        The TOML file; the specimen's path in it is relative to its folder.
    trust : bool
        Allow settings that could run code or write files.
    notice : callable
        Called with a line of text from time to time, if there are many cases to check.

    Raises
    ------
    InputError
        A file is missing or malformed, a field is unknown, or a case is not valid: the message
        names the case and the field.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> import bilayer
    >>> folder = pathlib.Path(tempfile.mkdtemp())
    >>> text = bilayer.specimen_to_toml(bilayer.paper_specimen())
    >>> _ = (folder / "specimen.toml").write_text(text)
    >>> _ = (folder / "study.toml").write_text('''
    ... specimen = "specimen.toml"
    ... solver = "dshell"
    ... vary = { "cut.strips" = [4, 5], "mesh.size" = [0.014], "prestretch.milestones" = [1.02] }
    ... ''')
    >>> len(bilayer.read_study(folder / "study.toml").cases)
    2
    """
    tables = _tables(Path(path))
    specimen_file = tables.get("specimen")
    if not isinstance(specimen_file, str):
        raise InputError(
            f"study file {path}: specimen = {shown(specimen_file)}: expected a file name"
        )
    specimen_path = Path(path).parent / specimen_file
    specimen_text = read_text(specimen_path, "specimen file")
    solvers = _solvers(tables.get("solver"))
    settings = _settings_tables(tables.get("settings", {}), solvers)
    varied = _varied_rows(tables)
    _check_fields(varied[0], solvers)
    plan = make_plan(specimen_text, solvers, settings, varied, specimen_path.parent, notice)
    if not trust:
        for case in plan.cases:
            check_plain(case.settings)
    return plan


def make_plan(
    specimen_text: str,
    solvers: Sequence[str],
    settings: Mapping[str, Mapping[str, Any]],
    rows: Sequence[Row],
    folder: Path | None = None,
    notice: Notice = keep_quiet,
) -> StudyPlan:
    """Return the plan of some rows of values, each with every solver.

    Parameters
    ----------
    specimen_text : str
        The specimen that is varied, as TOML.
    solvers : sequence of str
        Names as in `bilayer.solvers.registry`.
    settings : mapping
        For each solver a table of its `model` and settings, as far as they are not the defaults.
    rows : sequence of dict
        Values by dotted name, the same names in each.
    folder : Path, optional
        Where the drawings lie that the specimen names.
    notice : callable
        See `read_study`.
    """
    cases: dict[str, Case] = {}
    complaints = []
    wanted = list(product(solvers, _load_paths(rows)))
    told = time.monotonic()
    for number, (solver, (values, milestones)) in enumerate(wanted, start=1):
        if time.monotonic() - told > SECONDS_BETWEEN_NOTICES:
            told = time.monotonic()
            notice(f"{number} of {len(wanted)} cases checked")
        own = {name: value for name, value in values.items() if _concerns(name, solver)}
        try:
            chosen = settings.get(solver, {})
            case = _case(specimen_text, solver, chosen, own, milestones, folder)
        except InputError as error:
            words = ", ".join(f"{name} = {value}" for name, value in own.items())
            complaints.append(f"case {number} ({words or solver}): {error}")
        else:
            cases.setdefault(case.identity, case)
    if complaints:
        others = f" (and {len(complaints) - 1} more such cases)" if len(complaints) > 1 else ""
        raise InputError(complaints[0] + others)
    names = [name for name in rows[0] if name != MILESTONES_FIELD]
    fields = [SOLVER_FIELD, *names] if len(solvers) > 1 else names
    return StudyPlan(tuple(fields), tuple(cases.values()))


def _tables(path: Path) -> dict[str, Any]:
    tables = parse_toml(read_text(path, "study file"), f"study file {path}")
    for key in tables:
        if key not in KEYS:
            expected = f"expected one of {', '.join(KEYS)}"
            raise InputError(f"study file {path}: {key}: unknown, {expected}{nearest(key, KEYS)}")
    for key in ("settings", "vary", "zip", "sample"):
        if not isinstance(tables.get(key, {}), dict):
            raise InputError(
                f"study file {path}: {key} = {shown(tables[key])}: expected a table [{key}]"
            )
    return tables


def _solvers(given: Any) -> list[str]:
    names = given if isinstance(given, list) else [given]
    if not names:
        raise InputError("solver = []: expected at least one")
    return list(dict.fromkeys(one_of("solver", name, SOLVERS) for name in names))


def _settings_tables(given: Mapping[str, Any], solvers: Iterable[str]) -> dict[str, Any]:
    for name, table in given.items():
        one_of("settings", name, solvers)
        if not isinstance(table, Mapping):
            raise InputError(f"settings.{name} = {table!r}: expected a table [settings.{name}]")
    return dict(given)


def _varied_rows(tables: Mapping[str, Any]) -> list[Row]:
    parts = [
        product_rows(named_fields(tables.get("vary", {}))),
        zipped_rows(named_fields(tables.get("zip", {}))),
        sampled_rows(named_fields(tables.get("sample", {}))),
    ]
    check_count(math.prod(map(len, parts)))
    names = [name for rows in parts for name in rows[0]]
    twice = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twice:
        raise InputError(f"{twice[0]}: given in two of [vary], [zip], [sample], expected one")
    return [{**a, **b, **c} for a, b, c in product(*parts)]


def _check_fields(names: Iterable[str], solvers: Sequence[str]) -> None:
    """Check what the specimen's own reader cannot: the names of settings."""
    for name in names:
        table, _, rest = name.partition(".")
        if table == SOLVER_FIELD:
            raise InputError(f"{name}: expected settings.{solvers[0]}.{rest or 'NAME'}")
        if table == "settings":
            solver, _, setting = rest.partition(".")
            one_of(f"solver of the field {name}", solver, solvers)
            if not setting:
                raise InputError(f"{name}: expected settings.{solver}.NAME")


def _load_paths(rows: Sequence[Row]) -> list[tuple[Row, list[Any]]]:
    """Return the rows without their prestretch, each once, and the prestretches of each."""
    paths: dict[str, tuple[Row, list[Any]]] = {}
    for row in rows:
        values = {name: value for name, value in row.items() if name != MILESTONES_FIELD}
        _, milestones = paths.setdefault(json.dumps(values), (values, []))
        if MILESTONES_FIELD in row and row[MILESTONES_FIELD] not in milestones:
            milestones.append(row[MILESTONES_FIELD])
    return list(paths.values())


def _concerns(name: str, solver: str) -> bool:
    return not name.startswith("settings.") or name.startswith(f"settings.{solver}.")


def _case(
    specimen_text: str,
    solver: str,
    settings: Mapping[str, Any],
    values: Row,
    milestones: list[Any],
    folder: Path | None,
) -> Case:
    prefix = f"settings.{solver}."
    chosen = dict(settings)
    overrides = []
    for name, value in values.items():
        if name.startswith(prefix):
            chosen[name.removeprefix(prefix)] = value
        else:
            overrides.append(f"{name}={json.dumps(value)}")
    if milestones:
        overrides.append(f"{MILESTONES_FIELD}={json.dumps(_ascending(milestones))}")
    specimen = parse_specimen_file(specimen_text, overrides, "the study's specimen", folder)
    model = chosen.pop("model", next(iter(solver_named(solver).models)))
    kind: Any = settings_class(solver, model)
    return Case(specimen, solver, model, settings_from(kind, chosen), values)


def _ascending(milestones: list[Any]) -> list[Any]:
    """Return the milestones in the order of a load path: by the larger number, then the other."""
    try:
        return sorted(milestones, key=lambda stretch: sorted(np.broadcast_to(stretch, 2))[::-1])
    except (TypeError, ValueError):
        return milestones  # no numbers, or no pair: the specimen's reader says so
