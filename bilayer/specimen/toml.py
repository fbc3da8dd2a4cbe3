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

from bilayer.errors import InputError, fields_of
from bilayer.specimen.layer import Layer
from bilayer.specimen.material import Law, LinearElastic, MooneyRivlin, NeoHookean
from bilayer.specimen.outline import Disc
from bilayer.specimen.pattern import CutPattern
from bilayer.specimen.prestretch import Prestretch
from bilayer.specimen.specimen import MeshSize, Specimen
from bilayer.specimen.two_layers import SUBSTRATE, TwoLayers, disc_bilayer
from bilayer.validation import nearest, one_of

LAWS: dict[str, Any] = {
    "mooney-rivlin": MooneyRivlin,
    "neo-hookean": NeoHookean,
    "linear": LinearElastic,
}
_MODULI = ("young_modulus", "poisson_ratio", "c01_over_c10")
_CONSTANTS = ("c10", "c01", "d1")
_LAYER = ("thickness", "law", *_MODULI, *_CONSTANTS, "density")
_LAW_KEYS = {
    "mooney-rivlin": (*_MODULI, *_CONSTANTS),
    "neo-hookean": ("young_modulus", "poisson_ratio", "c10", "d1"),
    "linear": ("young_modulus", "poisson_ratio"),
}
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
    kirigami = dict(data.get("kirigami", {}))
    side = kirigami.pop("side", "above")
    path = data.get("prestretch", {})
    with fields_of("specimen"):
        disc = Disc(_required(data, "specimen", "outer_radius"))
    return disc_bilayer(
        name=data.get("specimen", {}).get("name", "specimen"),
        outer_radius=disc.radius,
        cut=_cut(data, disc) if "cut" in data else None,
        substrate=_layer("substrate", data.get("substrate", {})),
        kirigami=_layer("kirigami", kirigami),
        prestretch=Prestretch(
            _required(data, "prestretch", "milestones"),
            **{key: path[key] for key in ("thickness",) if key in path},
        ),
        stretched=path.get("layers", [SUBSTRATE]),
        gravity=data.get("gravity", {}).get("acceleration", 0.0),
        mesh=MeshSize(**data.get("mesh", {})),
        kirigami_side=side,
    )


def specimen_to_toml(specimen: Specimen) -> str:
    """Return the TOML text that reads back as the same specimen.

    Materials are written by the constants that they hold, so that no digit is lost.
    """
    bilayer, cut = TwoLayers.of(specimen, "a specimen file"), specimen.layer("kirigami").pattern
    assert isinstance(specimen.outline, Disc)
    tables: dict[str, Any] = {
        "specimen": {"name": specimen.name, "outer_radius": specimen.outline.radius}
    }
    if cut is not None:
        tables["cut"] = {key: getattr(cut, key) for key in TABLES["cut"]}
    tables["substrate"] = _layer_table(bilayer.substrate)
    tables["kirigami"] = _layer_table(bilayer.kirigami) | {"side": bilayer.kirigami_side}
    tables["prestretch"] = {
        "milestones": [x if x == y else [x, y] for x, y in specimen.prestretch.milestones],
        "layers": list(bilayer.stretched),
        "thickness": specimen.prestretch.thickness,
    }
    tables["gravity"] = {"acceleration": specimen.gravity}
    tables["mesh"] = {key: value for key, value in vars(specimen.mesh).items() if value is not None}
    return tomli_w.dumps(tables)


def _check_known(table: str, key: str) -> None:
    if table not in TABLES:
        raise InputError(f"{table}.{key}: unknown table {table!r}{nearest(table, TABLES)}")
    if key not in TABLES[table]:
        expected = f"expected one of {', '.join(TABLES[table])}"
        raise InputError(f"{table}.{key}: unknown key, {expected}{nearest(key, TABLES[table])}")


def _required(data: Mapping[str, Any], table: str, key: str) -> Any:
    try:
        return data[table][key]
    except KeyError:
        raise InputError(f"{table}.{key}: missing, expected a value in table [{table}]") from None


def _cut(data: Mapping[str, Any], outline: Disc) -> CutPattern:
    given = {key: _required(data, "cut", key) for key in TABLES["cut"]}
    if given["strips"] == 0:
        raise InputError("cut.strips = 0: leave the [cut] table out for an uncut disc")
    with fields_of("cut"):
        cut = CutPattern(**given)
        cut.check_fit(outline)
    return cut


def _layer(table: str, content: Mapping[str, Any]) -> Layer:
    thickness = _required({table: content}, table, "thickness")
    law = one_of(f"{table}.law", content.get("law", "mooney-rivlin"), LAWS)
    given = {
        key: value for key, value in content.items() if key not in ("thickness", "law", "density")
    }
    for key in given:
        if key not in _LAW_KEYS[law]:
            raise InputError(
                f"{table}.{key}: not a constant of law = {law!r}, "
                f"expected {', '.join(_LAW_KEYS[law])}"
            )
    with fields_of(table):
        return Layer(table, thickness, _material(law, given), content.get("density", 960.0))


def _material(law: str, given: Mapping[str, Any]) -> Law:
    by_constants = [key for key in given if key in _CONSTANTS]
    by_moduli = [key for key in given if key in _MODULI]
    if by_constants and by_moduli:
        raise InputError(
            f"{by_constants[0]}: given together with {by_moduli[0]}, expected either "
            f"{', '.join(_CONSTANTS)} or {', '.join(_MODULI)}"
        )
    if by_constants:
        needed = [key for key in _CONSTANTS if key in _LAW_KEYS[law]]
        _check_complete(given, needed)
        return LAWS[law](**given)
    _check_complete(given, ["young_modulus", "poisson_ratio"])
    return LAWS[law](**given) if law == "linear" else LAWS[law].from_moduli(**given)


def _check_complete(given: Mapping[str, Any], needed: list[str]) -> None:
    for key in needed:
        if key not in given:
            raise InputError(f"{key}: missing, expected {' and '.join(needed)}")


def _layer_table(layer: Layer) -> dict[str, Any]:
    law = next(name for name, kind in LAWS.items() if type(layer.material) is kind)
    constants = vars(layer.material)
    keys = _LAW_KEYS[law] if law == "linear" else [k for k in _CONSTANTS if k in _LAW_KEYS[law]]
    return {
        "thickness": layer.thickness,
        "law": law,
        **{key: constants[key] for key in keys},
        "density": layer.density,
    }
