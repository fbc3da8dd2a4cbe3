"""Laws as tables of a specimen file."""

from collections.abc import Callable, Mapping
from typing import Any

from bilayer.errors import InputError, fields_of
from bilayer.specimen.material import Law, LinearElastic, MooneyRivlin, NeoHookean
from bilayer.validation import one_of

DEFAULT_LAW = "mooney-rivlin"
LAWS: dict[str, Any] = {
    "mooney-rivlin": MooneyRivlin,
    "neo-hookean": NeoHookean,
    "linear": LinearElastic,
}
_MODULI = {"young_modulus": "Pa", "poisson_ratio": "", "c01_over_c10": ""}
_CONSTANTS = {"c10": "Pa", "c01": "Pa", "d1": "1/Pa"}
_LAW_KEYS = {
    "mooney-rivlin": (*_MODULI, *_CONSTANTS),
    "neo-hookean": ("young_modulus", "poisson_ratio", "c10", "d1"),
    "linear": ("young_modulus", "poisson_ratio"),
}


def law_keys() -> dict[str, str]:
    """Return all keys that give a law in a file, each with its unit, that of the choice first."""
    return {"law": ""} | _MODULI | _CONSTANTS


def law_from_table(table: Mapping[str, Any], where: str) -> Law:
    """Return the law of a table of a specimen file.

    Parameters
    ----------
    table : mapping
        `law` and either all of its constants or its moduli.
    where : str
        Name of the table, for messages.

    Raises
    ------
    InputError
        The law or a key is unknown, a key is missing, or a value is out of its range.
    """
    law = one_of(f"{where}.law", table.get("law", DEFAULT_LAW), LAWS)
    given = {key: value for key, value in table.items() if key != "law"}
    for key in given:
        if key not in _LAW_KEYS[law]:
            raise InputError(
                f"{where}.{key}: not a constant of law = {law!r}, "
                f"expected {', '.join(_LAW_KEYS[law])}"
            )
    with fields_of(where):
        return _law(law, given)


def law_to_table(law: Law) -> dict[str, Any]:
    """Return the table that reads back as the same law, by its constants, so no digit is lost."""
    name = next(name for name, kind in LAWS.items() if type(law) is kind)
    own = _LAW_KEYS[name]
    keys = own if name == "linear" else [key for key in _CONSTANTS if key in own]
    return {"law": name} | {key: getattr(law, key) for key in keys}


def _law(law: str, given: Mapping[str, Any]) -> Law:
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
        return _made(LAWS[law], given)
    _check_complete(given, ["young_modulus", "poisson_ratio"])
    return _made(LAWS[law] if law == "linear" else LAWS[law].from_moduli, given)


def _made(make: Callable[..., Law], given: Mapping[str, Any]) -> Law:
    return make(**given)


def _check_complete(given: Mapping[str, Any], needed: list[str]) -> None:
    for key in needed:
        if key not in given:
            raise InputError(f"{key}: missing, expected {' and '.join(needed)}")
