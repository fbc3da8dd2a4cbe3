"""The specimen as a TOML file: reading, overriding single keys by dotted name, writing.

The tables and keys are the public contract of the project; `template()` is its commented example.
"""

import copy
import tomllib
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

import tomli_w

from bilayer.errors import InputError
from bilayer.specimen.materials import law_from_table, law_keys, law_to_table
from bilayer.specimen.specimen import LAYERS, CutPattern, Layer, MeshSize, Prestretch, Specimen
from bilayer.validation import nearest

_LAYER = ("thickness", "density")
"""Keys of a layer besides those of its law."""
TABLES: dict[str, tuple[str, ...]] = {
    "specimen": ("name", "outer_radius"),
    "cut": ("strips", "inner_radius", "cutout_angle"),
    "substrate": _LAYER,
    "kirigami": (*_LAYER, "side"),
    "prestretch": ("milestones", "layers", "thickness"),
    "gravity": ("acceleration",),
    "mesh": ("size", "corner_size"),
}


def template() -> str:
    """Return the commented TOML text of the paper's specimen."""
    return files("bilayer.specimen").joinpath("paper.toml").read_text(encoding="utf-8")


def paper_specimen() -> Specimen:
    """Return the paper's specimen (section V), as the template states it."""
    return parse_specimen(template())


def read_specimen(path: str | Path, overrides: Iterable[str] = ()) -> Specimen:
    """Read a specimen from a TOML file.

    Parameters
    ----------
    path : path-like
        The file.
    overrides : iterable of str
        `"table.key=value"` texts that replace or add single keys, the value written as in TOML.

    Raises
    ------
    InputError
        The file is missing or malformed, a key is unknown, or a value is out of its range.
    """
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not a text file"
        raise InputError(f"specimen file {path}: cannot be read ({reason})") from error
    return parse_specimen(text, overrides, source=str(path))


def parse_specimen(
    text: str, overrides: Iterable[str] = (), source: str = "specimen text"
) -> Specimen:
    """Read a specimen from TOML text; see `read_specimen`."""
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{source}: not a valid TOML file ({error})") from error
    return specimen_from_tables(with_overrides(data, overrides))


def with_overrides(data: Mapping[str, Any], overrides: Iterable[str]) -> dict[str, Any]:
    """Return the tables with `"table.key=value"` texts applied.

    Raises
    ------
    InputError
        An override is not of that form or names no key of a specimen.
    """
    tables = copy.deepcopy(dict(data))
    for override in overrides:
        name, separator, value = override.partition("=")
        table, dot, key = name.strip().partition(".")
        if not (separator and dot and key):
            raise InputError(f"override {override!r}: expected table.key=value")
        _check_known(table, key)
        if not isinstance(tables.setdefault(table, {}), dict):
            raise InputError(f"{table} = {tables[table]!r}: expected a table [{table}]")
        tables[table][key] = toml_value(value)
    return tables


def toml_value(text: str) -> Any:
    """Return `text` read as one TOML value, or as a plain string where it is none."""
    try:
        table = tomllib.loads(f"value = {text.strip()}")
    except tomllib.TOMLDecodeError:
        return text.strip()
    return table["value"] if list(table) == ["value"] else text


def specimen_from_tables(data: Mapping[str, Any]) -> Specimen:
    """Return the specimen of parsed TOML tables; see `read_specimen` for what is raised."""
    for table, content in data.items():
        if table not in TABLES:
            known = f"expected [{'], ['.join(TABLES)}]"
            raise InputError(f"[{table}]: unknown table, {known}{nearest(table, TABLES)}")
        if not isinstance(content, Mapping):
            raise InputError(f"{table} = {content!r}: expected a table [{table}]")
        for key in content:
            _check_known(table, key)
    cut = data.get("cut")
    kirigami = dict(data.get("kirigami", {}))
    side = kirigami.pop("side", "above")
    name = data.get("specimen", {}).get("name", "specimen")
    if not isinstance(name, str):
        raise InputError(f"specimen.name = {name!r}: expected a text")
    return Specimen(
        name=name,
        outer_radius=_required(data, "specimen", "outer_radius"),
        cut=None if cut is None else _cut(data),
        substrate=_layer("substrate", data.get("substrate", {})),
        kirigami=_layer("kirigami", kirigami),
        prestretch=Prestretch(
            milestones=_required(data, "prestretch", "milestones"),
            **{
                key: data["prestretch"][key]
                for key in ("thickness", "layers")
                if key in data["prestretch"]
            },
        ),
        gravity=data.get("gravity", {}).get("acceleration", 0.0),
        mesh=MeshSize(**data.get("mesh", {})),
        kirigami_side=side,
    )


def specimen_to_toml(specimen: Specimen) -> str:
    """Return the TOML text that reads back as the same specimen.

    Materials are written by the constants that they hold, so that no digit is lost.
    """
    tables: dict[str, Any] = {
        "specimen": {"name": specimen.name, "outer_radius": specimen.outer_radius}
    }
    if specimen.cut is not None:
        tables["cut"] = {key: getattr(specimen.cut, key) for key in TABLES["cut"]}
    tables["substrate"] = _layer_table(specimen.substrate)
    tables["kirigami"] = _layer_table(specimen.kirigami) | {"side": specimen.kirigami_side}
    tables["prestretch"] = {
        "milestones": [x if x == y else [x, y] for x, y in specimen.prestretch.milestones],
        "layers": list(specimen.prestretch.layers),
        "thickness": specimen.prestretch.thickness,
    }
    tables["gravity"] = {"acceleration": specimen.gravity}
    tables["mesh"] = {key: value for key, value in vars(specimen.mesh).items() if value is not None}
    return tomli_w.dumps(tables)


def _check_known(table: str, key: str) -> None:
    if table not in TABLES:
        raise InputError(f"{table}.{key}: unknown table {table!r}{nearest(table, TABLES)}")
    known = (*TABLES[table], *(law_keys() if table in LAYERS else ()))
    if key not in known:
        expected = f"expected one of {', '.join(known)}"
        raise InputError(f"{table}.{key}: unknown key, {expected}{nearest(key, known)}")


def _required(data: Mapping[str, Any], table: str, key: str) -> Any:
    try:
        return data[table][key]
    except KeyError:
        raise InputError(f"{table}.{key}: missing, expected a value in table [{table}]") from None


def _cut(data: Mapping[str, Any]) -> CutPattern:
    return CutPattern(**{key: _required(data, "cut", key) for key in TABLES["cut"]})


def _layer(table: str, content: Mapping[str, Any]) -> Layer:
    thickness = _required({table: content}, table, "thickness")
    law = {key: value for key, value in content.items() if key not in _LAYER}
    material = law_from_table(law, table)
    try:
        return Layer(thickness, material, content.get("density", 960.0))
    except InputError as error:
        raise InputError(f"{table}.{error}") from error


def _layer_table(layer: Layer) -> dict[str, Any]:
    return {
        "thickness": layer.thickness,
        **law_to_table(layer.material),
        "density": layer.density,
    }
