"""The tables [supports.NAME] and [loads.NAME] of a specimen file."""

from collections.abc import Mapping
from typing import Any

from bilayer.errors import InputError, fields_of
from bilayer.specimen.load import LOAD_KINDS, MOST_LOADS, Load
from bilayer.specimen.part import BORDERS, MEASURED, RELATIONS, Limit, Part
from bilayer.specimen.supported import Support
from bilayer.specimen.units import in_si
from bilayer.validation import listed, nearest, shown

SUPPORT = ("kind", "where", "axes")
LOAD = (*LOAD_KINDS, "where", "direction")
WHERE = ("on", *MEASURED, "point", "line")
DIRECTIONS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def supports_from(tables: Mapping[str, Any]) -> tuple[Support, ...]:
    """Return the supports of the table `supports` of a file; InputError if one is none."""
    return tuple(_support(name, content) for name, content in _items("supports", tables))


def loads_from(tables: Mapping[str, Any]) -> tuple[Load, ...]:
    """Return the loads of the table `loads` of a file; InputError if one is none."""
    return tuple(_load(name, content) for name, content in _items("loads", tables))


def supports_to(supports: tuple[Support, ...]) -> dict[str, Any]:
    """Return the table that reads back as the same supports."""
    return {
        each.name: {"kind": each.kind, "where": _where_to(each.part), "axes": each.axes}
        for each in supports
    }


def loads_to(loads: tuple[Load, ...]) -> dict[str, Any]:
    """Return the table that reads back as the same loads."""
    tables = {}
    for load in loads:
        table: dict[str, Any] = {load.kind: list(load.values), "where": _where_to(load.part)}
        if load.kind != "pressure":
            table["direction"] = list(load.direction)
        tables[load.name] = table
    return tables


def _items(table: str, tables: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
    if len(tables) > MOST_LOADS:
        raise InputError(f"{table}: there are {len(tables)}, expected at most {MOST_LOADS}")
    for name, content in tables.items():
        if not isinstance(content, Mapping):
            raise InputError(f"{table}.{name} = {shown(content)}: expected a table [{table}.NAME]")
    return list(tables.items())


def _support(name: str, content: Mapping[str, Any]) -> Support:
    where = f"supports.{name}"
    _check_keys(where, content, SUPPORT)
    if "kind" not in content:
        raise InputError(f"{where}.kind: missing, expected 'clamped', 'hinged' or 'guided'")
    part = _part(f"{where}.where", content.get("where", "rim"))
    if not content.get("axes", True):
        axes = shown(content["axes"])
        raise InputError(f"{where}.axes = {axes}: expected some of 'xyz', such as 'z'")
    with fields_of(where):
        return Support(name, content["kind"], part, content.get("axes", ""))


def _load(name: str, content: Mapping[str, Any]) -> Load:
    where = f"loads.{name}"
    _check_keys(where, content, LOAD)
    kinds = [kind for kind in LOAD_KINDS if kind in content]
    if len(kinds) != 1:
        raise InputError(f"{where}: expected one of {', '.join(LOAD_KINDS)} in it")
    (kind,) = kinds
    given = content[kind]
    values = [_value(f"{where}.{kind}", kind, value) for value in _list(given)]
    part = _part(f"{where}.where", content.get("where", "sheet"))
    with fields_of(where):
        return Load(name, kind, tuple(values), part, **_direction(where, kind, content))


def _value(field: str, kind: str, value: Any) -> Any:
    if value == "free":
        return value
    return _quantity(field, value, LOAD_KINDS[kind])


def _direction(where: str, kind: str, content: Mapping[str, Any]) -> dict[str, Any]:
    """Return the direction of a load if it has one."""
    if "direction" not in content:
        return {}
    if kind == "pressure":
        raise InputError(f"{where}.direction: a pressure has none, expected it left out")
    given = content["direction"]
    if not isinstance(given, str):
        return {"direction": given}
    sign, axis = (-1.0, given[1:]) if given.startswith("-") else (1.0, given)
    if axis not in DIRECTIONS:
        raise InputError(f"{where}.direction = {shown(given)}: expected 'z', '-z' or [x, y, z]")
    return {"direction": tuple(sign * part for part in DIRECTIONS[axis])}


def _part(field: str, given: Any) -> Part:
    if isinstance(given, str):
        given = {"on": given}
    if not isinstance(given, Mapping):
        raise InputError(
            f"{field} = {shown(given)}: expected one of {', '.join(BORDERS)}, or a table such as "
            "{ on = 'rim', x = '<= -19 mm' }"
        )
    _check_keys(field, given, WHERE)
    limits = [
        _limit(f"{field}.{measured}", measured, text)
        for measured in MEASURED
        for text in _list(given.get(measured, []))
    ]
    point = given.get("point")
    place = None if point is None else _quantity(f"{field}.point", point, "m")
    line = _quantity(f"{field}.line", given.get("line", []), "m")
    with fields_of(field):
        line = tuple(listed("line", line))
        return Part(given.get("on", "sheet"), tuple(limits), place, line)


def _limit(field: str, measured: str, text: Any) -> Limit:
    relation = text[:2] if isinstance(text, str) else ""
    if relation not in RELATIONS:
        raise InputError(f"{field} = {shown(text)}: expected such as '<= 19 mm' or '>= 19 mm'")
    words = text[2:].strip()
    try:
        bound: Any = float(words)
    except ValueError:
        bound = _quantity(field, words, "m")
    with fields_of(field):
        return Limit(measured, relation, bound)


def _where_to(part: Part) -> dict[str, Any]:
    """Return the table of a part."""
    table: dict[str, Any] = {"on": part.on}
    for measured in MEASURED:
        texts = [f"{a.relation} {a.bound!r}" for a in part.limits if a.measured == measured]
        table |= {measured: texts} if texts else {}
    if part.point is not None:
        table["point"] = list(part.point)
    if part.line:
        table["line"] = [list(place) for place in part.line]
    return table


def _quantity(field: str, value: Any, unit: str) -> Any:
    """Return a value, or the values of a list, in an SI unit."""
    table, _, key = field.rpartition(".")
    return in_si(table, {key: value}, {key: unit})[key]


def _list(given: Any) -> list[Any]:
    return given if isinstance(given, list) else [given]


def _check_keys(table: str, content: Mapping[str, Any], known: tuple[str, ...]) -> None:
    for key in content:
        if key not in known:
            expected = f"expected one of {', '.join(known)}"
            raise InputError(f"{table}.{key}: unknown key, {expected}{nearest(key, known)}")
