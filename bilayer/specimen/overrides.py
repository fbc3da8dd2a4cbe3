"""Single values of a specimen file replaced by dotted name: `cut.strips=6`.

A layer of `[[layers]]` is named by its own name: `layers.substrate.thickness="0.8 mm"`.
"""

import copy
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.tables import check_keys
from bilayer.specimen.toml_text import parse_toml
from bilayer.validation import nearest


def with_overrides(
    data: Mapping[str, Any], overrides: Iterable[str], known: Mapping[str, Iterable[str]]
) -> dict[str, Any]:
    """Return the tables of a file with `"table.key=value"` texts applied.

    Parameters
    ----------
    data : mapping
        The tables.
    overrides : iterable of str
        The value is written as in TOML.
    known : mapping of str to iterable of str
        All tables that there are, each with its keys; without any if it has tables of its own.

    Raises
    ------
    InputError
        An override is not of that form or names no key of a specimen.
    """
    tables = copy.deepcopy(dict(data))
    for override in overrides:
        name, separator, value = override.partition("=")
        table, *path = [part.strip() for part in name.split(".")]
        if not (separator and table and path and all(path)):
            raise InputError(
                f"override {override!r}: expected table.key=value, such as cut.strips=6"
            )
        if table not in known:
            raise InputError(f"{name}: unknown table {table!r}{nearest(table, known)}")
        if known[table]:
            check_keys(table, path[:1], known[table])
            tables.setdefault(table, {})
        elif len(path) < 2:
            raise InputError(f"override {override!r}: expected {name.strip()}.key=value")
        place = _place(tables, [table, *path[:-1]])
        place[path[-1]] = toml_value(name.strip(), value)
    return tables


def toml_value(field: str, text: str) -> Any:
    """Return the text of a field read as one TOML value, or as a plain string if it is none."""
    try:
        table = parse_toml(f"value = {text.strip()}", f"{field} = {text.strip()[:40]!r}")
    except InputError as error:
        if not isinstance(error.__cause__, tomllib.TOMLDecodeError):
            raise
        return text.strip()
    return table["value"] if list(table) == ["value"] else text


def _place(tables: dict[str, Any], path: Iterable[str]) -> dict[str, Any]:
    """Return the table at a path of names."""
    place: Any = tables
    so_far: list[str] = []
    for name in path:
        there = _children(place)
        if name not in there:
            known = f"expected one of {', '.join(there)}" if there else "there is none"
            where = ".".join([*so_far, name])
            raise InputError(f"{where}: not in this specimen file, {known}{nearest(name, there)}")
        place = there[name]
        so_far.append(name)
    if not isinstance(place, dict):
        where = ".".join(so_far)
        raise InputError(f"{where} = {place!r}: expected a table [{where}]")
    return place


def _children(place: Any) -> dict[str, Any]:
    """Return the entry of a name in a table, or in a list of tables with names."""
    if isinstance(place, list):
        return {str(item.get("name")): item for item in place if isinstance(item, dict)}
    return place if isinstance(place, dict) else {}
