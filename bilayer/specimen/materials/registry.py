"""The laws by the names that a specimen file gives them, and laws as tables of such a file."""

import inspect
from collections.abc import Mapping
from typing import Any

from bilayer.errors import InputError
from bilayer.specimen.materials.arruda_boyce import ArrudaBoyce
from bilayer.specimen.materials.gent import Gent
from bilayer.specimen.materials.law import Law
from bilayer.specimen.materials.linear import LinearElastic
from bilayer.specimen.materials.mooney_rivlin import MooneyRivlin
from bilayer.specimen.materials.neo_hookean import NeoHookean
from bilayer.specimen.materials.ogden import Ogden
from bilayer.specimen.materials.yeoh import Yeoh
from bilayer.validation import one_of

DEFAULT_LAW = "mooney-rivlin"
LAWS: dict[str, Any] = {}
"""Classes of laws by name."""


def register_law(kind: Any) -> Any:
    """Make a class of laws known by its name; a decorator.

    Raises
    ------
    InputError
        Another law has the name, or the class lacks what a specimen file needs of it.

    Examples
    --------
    A law is a class with constants, their units and its energy; docs/materials.md has a whole one.

    >>> import bilayer
    >>> bilayer.register_law(bilayer.NeoHookean) is bilayer.NeoHookean
    True
    """
    name = getattr(kind, "name", None)
    if not isinstance(name, str) or not isinstance(getattr(kind, "units", None), Mapping):
        raise InputError(f"law {kind.__name__}: expected a name and the units of its constants")
    known = LAWS.setdefault(name, kind)
    if known is not kind:
        raise InputError(f"law = {name!r}: the name is taken by {known.__name__}")
    return kind


for _kind in (MooneyRivlin, NeoHookean, LinearElastic, Yeoh, Gent, ArrudaBoyce, Ogden):
    register_law(_kind)


def law_keys() -> dict[str, str]:
    """Return all keys that give a law in a file, each with its unit, that of the choice first."""
    keys = {"law": ""}
    for kind in LAWS.values():
        keys |= kind.moduli
    for kind in LAWS.values():
        keys |= kind.units
    return keys


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
    name = one_of(f"{where}.law", table.get("law", DEFAULT_LAW), LAWS)
    kind = LAWS[name]
    given = {key: value for key, value in table.items() if key != "law"}
    known = list(kind.moduli | kind.units)
    for key in given:
        if key not in known:
            raise InputError(
                f"{where}.{key}: not a constant of law = {name!r}, expected {', '.join(known)}"
            )
    try:
        return _law_of(kind, given)
    except InputError as error:
        raise InputError(f"{where}.{error}") from error


def _law_of(kind: Any, given: Mapping[str, Any]) -> Law:
    constants = [key for key in given if key in kind.units]
    moduli = [key for key in given if key in kind.moduli]
    by_moduli = [key for key in moduli if key not in kind.units]
    by_constants = [key for key in constants if key not in kind.moduli]
    if by_constants and by_moduli:
        raise InputError(
            f"{by_constants[0]}: given together with {by_moduli[0]}, expected either "
            f"{', '.join(kind.units)} or {', '.join(kind.moduli)}"
        )
    if by_constants or not kind.moduli:
        _check_complete(given, list(kind.units))
        return kind(**given)
    needed = inspect.signature(kind.from_moduli).parameters.values()
    _check_complete(given, [p.name for p in needed if p.default is p.empty])
    return kind.from_moduli(**given)


def _check_complete(given: Mapping[str, Any], needed: list[str]) -> None:
    for key in needed:
        if key not in given:
            raise InputError(f"{key}: missing, expected {' and '.join(needed)}")


def law_to_table(law: Law) -> dict[str, Any]:
    """Return the table that reads back as the same law, by its constants, so no digit is lost.

    Raises
    ------
    InputError
        The law is not registered.
    """
    name = getattr(law, "name", None)
    if name not in LAWS or LAWS[name] is not type(law):
        raise InputError(
            f"law {type(law).__name__}: not registered, expected one of {', '.join(LAWS)}"
        )
    return {"law": name} | {key: _plain(getattr(law, key)) for key in law.units}


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
