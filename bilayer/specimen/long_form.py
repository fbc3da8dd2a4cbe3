"""The long form of a specimen file: any outline, `[[layers]]` from the bottom up.

A layer names its material, a table `[materials.NAME]`, and its pattern, a table `[patterns.NAME]`.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from bilayer.errors import InputError, fields_of
from bilayer.specimen.layer import Layer, Response, layer_name
from bilayer.specimen.materials import Law, law_from_table, law_keys, law_to_table
from bilayer.specimen.outline import OUTLINES, Disc, Outline
from bilayer.specimen.pattern import Pattern
from bilayer.specimen.pattern_kinds import PATTERNS
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.schedule import Schedule
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.tables import (
    COMMON,
    Tables,
    as_table,
    check_keys,
    common_fields,
    last_tables,
    milestones_in_file,
    required,
)
from bilayer.specimen.units import UNITS, in_si
from bilayer.validation import nearest, one_of

LONG_TABLES = {
    **COMMON,
    "specimen": (*COMMON["specimen"], "outline"),
    "layers": (),
    "patterns": (),
    "materials": (),
    "time": ("milestones", "hold", "steps_per_decade"),
}
"""The tables of this form; those without keys hold tables of their own."""
RELAXATION = "relaxation"
"""Key of a material's Prony series."""
LAYER = ("name", "thickness", "material", "pattern", "response")
SHAPES = {name: kind for name, kind in OUTLINES.items() if kind is not Disc}


def sheet_from_tables(data: Tables) -> Specimen:
    """Return the specimen that the tables of a file describe.

    Raises
    ------
    InputError
        A key is unknown or missing, or a value is out of its range.
    """
    for table, content in data.items():
        if table == "prestretch" and "layers" in content:
            raise InputError(
                "prestretch.layers: expected response = 'path' in those of [[layers]] instead"
            )
        if LONG_TABLES[table]:
            check_keys(table, content, LONG_TABLES[table])
    outline = _outline(data.get("specimen", {}))
    given = data["layers"]
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise InputError(f"layers = {given!r}: expected tables [[layers]], from the bottom up")
    _check_names(given)
    layers = tuple(_layer(content, data) for content in given)
    schedule = _schedule(data["time"]) if "time" in data else None
    return Specimen(outline=outline, layers=layers, schedule=schedule, **common_fields(data))


def sheet_to_tables(specimen: Specimen) -> dict[str, Any]:
    """Return the tables that read back as the same specimen.

    Materials and patterns are named after the lowest layer that has them.
    """
    materials, patterns = _named(specimen, _material_key), _named(specimen, lambda la: la.pattern)
    tables: dict[str, Any] = {
        "specimen": {"name": specimen.name, **_outline_table(specimen.outline)},
        "layers": [
            {
                "name": layer.name,
                "thickness": layer.thickness,
                "material": materials[_material_key(layer)],
                **({} if layer.is_whole else {"pattern": patterns[layer.pattern]}),
                **({} if not layer.is_stretched else {"response": _response_table(layer.response)}),
            }
            for layer in specimen.layers
        ],
        "patterns": {
            name: _kind_table("kind", PATTERNS, pattern)
            for pattern, name in patterns.items()
            if pattern is not None
        },
        "materials": {
            name: law_to_table(law) | {"density": density} | _relaxation_table(relaxation)
            for (law, density, relaxation), name in materials.items()
        },
        "prestretch": {
            "milestones": milestones_in_file(specimen),
            "thickness": specimen.prestretch.thickness,
        },
        "time": {} if specimen.schedule is None else _time_table(specimen.schedule),
        **last_tables(specimen),
    }
    return {name: content for name, content in tables.items() if content}


def _schedule(content: Any) -> Schedule:
    quantities = in_si("time", as_table("time", content), {"milestones": "s", "hold": "s"})
    required("time", quantities, "milestones")
    return Schedule(**quantities)


def _time_table(schedule: Schedule) -> dict[str, Any]:
    return {field.name: _plain(getattr(schedule, field.name)) for field in fields(schedule)}


def _outline(sheet: Mapping[str, Any]) -> Outline:
    quantities = in_si("specimen", sheet)
    if "outline" not in sheet:
        radius = required("specimen", quantities, "outer_radius")
        with fields_of("specimen"):
            return Disc(radius)
    if "outer_radius" in sheet:
        raise InputError("specimen.outer_radius: not together with specimen.outline")
    table = as_table("specimen.outline", sheet["outline"])
    if table.get("shape") == "disc":
        raise InputError("specimen.outline.shape = 'disc': expected specimen.outer_radius alone")
    outline: Outline = _built("specimen.outline", "shape", SHAPES, table)
    return outline


def _layer(content: Any, data: Tables) -> Layer:
    name = content["name"]
    where = f"layers.{name}"
    check_keys(where, content, LAYER)
    quantities = in_si(where, content)
    thickness = required(where, quantities, "thickness")
    law, density, relaxation = _material(data, where, required(where, content, "material"))
    pattern = _pattern(data, where, content["pattern"]) if "pattern" in content else None
    response = _response(f"{where}.response", content.get("response", "none"))
    with fields_of(where):
        return Layer(name, thickness, law, density, pattern, response, relaxation)


def _check_names(layers: Sequence[Any]) -> None:
    for number, content in enumerate(layers):
        where = f"layers[{number}]"
        layer_name(f"{where}.name", required(where, as_table(where, content), "name"))


def _referred(data: Tables, table: str, field: str, name: Any) -> Mapping[str, Any]:
    """Return the table [materials.NAME] or [patterns.NAME] that a layer names."""
    known = as_table(table, data.get(table, {}))
    if not isinstance(name, str) or name not in known:
        listed = ", ".join(f"[{table}.{other}]" for other in known) or f"a table [{table}.NAME]"
        raise InputError(f"{field} = {name!r}: expected one of {listed}{nearest(name, known)}")
    return as_table(f"{table}.{name}", known[name])


def _material(data: Tables, where: str, name: Any) -> tuple[Law, Any, PronySeries]:
    """Return the law, the density and the relaxation of a table [materials.NAME]."""
    given = _referred(data, "materials", f"{where}.material", name)
    table = in_si(f"materials.{name}", given, UNITS | law_keys())
    check_keys(f"materials.{name}", table, (*law_keys(), "density", RELAXATION))
    density = table.pop("density", 960.0)
    field = f"materials.{name}.{RELAXATION}"
    relaxation = PronySeries.from_file(field, table.pop(RELAXATION, []))
    return law_from_table(table, f"materials.{name}"), density, relaxation


def _pattern(data: Tables, where: str, name: Any) -> Pattern:
    """Return the pattern of a table [patterns.NAME], or of one that stands in the layer."""
    if isinstance(name, Mapping):
        pattern: Pattern = _built(f"{where}.pattern", "kind", PATTERNS, name)
    else:
        table = _referred(data, "patterns", f"{where}.pattern", name)
        pattern = _built(f"patterns.{name}", "kind", PATTERNS, table)
    return pattern


def _response(field: str, given: Any) -> Response:
    table = {"kind": given} if isinstance(given, str) else as_table(field, given)
    required(field, table, "kind")
    check_keys(field, table, [item.name for item in fields(Response)])
    quantities = in_si(field, table)
    with fields_of(field):
        return Response(**quantities)


def _built(where: str, key: str, kinds: Mapping[str, type], table: Mapping[str, Any]) -> Any:
    """Return the object of one of several classes, its fields being the keys of a table."""
    kind = kinds[one_of(f"{where}.{key}", required(where, table, key), kinds)]
    names = [field.name for field in fields(kind)]
    check_keys(where, table, [key, *names])
    given = {name: value for name, value in table.items() if name != key}
    for field in fields(kind):
        if field.default is field.default_factory:  # both MISSING
            required(where, given, field.name)
    quantities = in_si(where, given)
    with fields_of(where):
        return kind(**quantities)


def _outline_table(outline: Outline) -> dict[str, Any]:
    if isinstance(outline, Disc):
        return {"outer_radius": outline.radius}
    return {"outline": _kind_table("shape", SHAPES, outline)}


def _kind_table(key: str, kinds: Mapping[str, type], value: Any) -> dict[str, Any]:
    """Return the table that `_built` reads; fields at their default None are left out."""
    name = next(name for name, kind in kinds.items() if type(value) is kind)
    content = {field.name: getattr(value, field.name) for field in fields(value)}
    return {key: name} | {k: _plain(v) for k, v in content.items() if v not in (None, ())}


def _response_table(response: Response) -> dict[str, Any]:
    default = Response()
    table = {field.name: getattr(response, field.name) for field in fields(response)}
    return {k: _plain(v) for k, v in table.items() if k == "kind" or v != getattr(default, k)}


def _material_key(layer: Layer) -> tuple[Any, float, PronySeries]:
    return layer.material, layer.density, layer.relaxation


def _relaxation_table(relaxation: PronySeries) -> dict[str, Any]:
    terms = [list(term) for term in relaxation.terms]
    return {RELAXATION: terms} if terms else {}


def _named(specimen: Specimen, what: Any) -> dict[Any, str]:
    """Return the properties of the layers, each with the name of the lowest layer that has it."""
    found: dict[Any, str] = {}
    for layer in specimen.layers:
        found.setdefault(what(layer), layer.name)
    return found


def _plain(value: Any) -> Any:
    return [_plain(item) for item in value] if isinstance(value, tuple) else value
