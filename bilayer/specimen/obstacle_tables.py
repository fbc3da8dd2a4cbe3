"""The tables [obstacles.NAME] of a specimen file."""

from collections.abc import Mapping
from dataclasses import MISSING, fields
from typing import Any

from bilayer.errors import InputError, fields_of
from bilayer.specimen.obstacle import MOST_OBSTACLES, OBSTACLES, Obstacle
from bilayer.specimen.units import in_si
from bilayer.validation import nearest, one_of, shown

UNITS = {"point": "m", "centre": "m", "radius": "m"}


def obstacles_from(tables: Mapping[str, Any]) -> tuple[Obstacle, ...]:
    """Return the obstacles of the table `obstacles` of a file; InputError if one is none."""
    if len(tables) > MOST_OBSTACLES:
        raise InputError(f"obstacles: there are {len(tables)}, expected at most {MOST_OBSTACLES}")
    return tuple(_obstacle(name, content) for name, content in tables.items())


def obstacles_to(obstacles: tuple[Obstacle, ...]) -> dict[str, Any]:
    """Return the table that reads back as the same obstacles."""
    shapes = {kind: shape for shape, kind in OBSTACLES.items()}
    tables = {}
    for each in obstacles:
        values = {key: _plain(getattr(each, key)) for key in _keys(type(each))}
        given = {key: value for key, value in values.items() if value is not None}
        tables[each.name] = {"shape": shapes[type(each)], **given}
    return tables


def _obstacle(name: str, content: Any) -> Obstacle:
    where = f"obstacles.{name}"
    if not isinstance(content, Mapping):
        raise InputError(f"{where} = {shown(content)}: expected a table [obstacles.NAME]")
    if "shape" not in content:
        raise InputError(f"{where}.shape: missing, expected 'plane' or 'sphere'")
    with fields_of(where):
        kind = OBSTACLES[one_of("shape", content["shape"], tuple(OBSTACLES))]
    known = _keys(kind)
    for key in content:
        if key not in ("shape", *known):
            expected = f"expected one of {', '.join(known)}"
            raise InputError(f"{where}.{key}: unknown key, {expected}{nearest(key, known)}")
    given = in_si(where, {key: content[key] for key in known if key in content}, UNITS)
    for field in fields(kind):
        if field.default is MISSING and field.name not in ("name", *given):
            raise InputError(f"{where}.{field.name}: missing, expected a value in [{where}]")
    with fields_of(where):
        return kind(name, **given)


def _keys(kind: type[Obstacle]) -> list[str]:
    """Return the keys of a shape."""
    return [each.name for each in fields(kind) if each.name != "name"]


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
