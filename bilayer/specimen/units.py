"""Quantities with units in specimen files: "40 mm" becomes metres, a bare number is in SI already.

Units end here: everything beyond the reader is in SI. pint is loaded when a unit is met for the
first time; it computes in decimal numbers, so that "1.1 mm" is the float 0.0011.
"""

import re
from collections.abc import Mapping
from decimal import Decimal
from functools import cache
from typing import Any

from bilayer.errors import ComputationError, InputError

UNITS: dict[str, str] = {
    **dict.fromkeys(
        ("outer_radius", "inner_radius", "corner_radius", "radii", "width", "height", "points",
         "holes", "polygons", "contours", "arm_width", "arm_length", "thickness", "size",
         "corner_size"), "m",
    ),
    **dict.fromkeys(("angle", "cutout_angle", "half_angles"), "rad"),
    "density": "kg/m^3",
    "acceleration": "m/s^2",
}  # fmt: skip
"""The SI unit of each key in a specimen file that has one, but for the constants of laws."""

LONGEST_UNIT = 60
"""Letters."""
_KINDS = {
    "m": ("a length", "40 mm"),
    "rad": ("an angle", "17.2 deg"),
    "Pa": ("a modulus", "116.25 kPa"),
    "1/Pa": ("a compressibility", "1e-5 1/Pa"),
    "kg/m^3": ("a density", "0.96 g/cm^3"),
    "m/s^2": ("an acceleration", "9.81 m/s^2"),
    "N": ("a force", "20 mN"),
    "N/m": ("a force per length", "1 N/m"),
    "N/m^3": ("a force per volume", "9.4 kN/m^3"),
    "s": ("a time", "60 s"),
}


def in_si(
    table: str, content: Mapping[str, Any], units: Mapping[str, str] = UNITS
) -> dict[str, Any]:
    """Return the entries of a table of a specimen file with their quantities in SI units.

    Parameters
    ----------
    table : str
        Its dotted name, for messages.
    content : mapping
        Values by key. Those of keys that have no unit, such as names, stay as they are.
    units : mapping of str to str
        The SI unit of each key that has one; the values of a list share it.

    Raises
    ------
    InputError
        A text is no number with a unit, or of another dimension than its key's.
    """
    return {
        key: _si(f"{table}.{key}", value, units[key]) if units.get(key) else value
        for key, value in content.items()
    }


def _si(field: str, value: Any, unit: str) -> Any:
    if isinstance(value, list):
        return [_si(field, item, unit) for item in value]
    return _converted(field, value, unit) if isinstance(value, str) else value


def _converted(field: str, text: str, unit: str) -> float:
    kind, example = _KINDS.get(unit, ("a quantity", f"1.5 {unit}"))
    wrong = InputError(
        f"{field} = {text!r}: expected {kind}, a number in {unit} or a text such as {example!r}"
        f"{_comma_hint(text)}"
    )
    parts = re.fullmatch(r"\s*([-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(\S.*?)\s*", text)
    if parts is None or not _is_plain_unit(parts[2]):
        raise wrong
    registry = _registry()
    try:
        powers = re.sub(r"([A-Za-z])(\d)", r"\1^\2", parts[2])  # "m3" is "m^3"
        given = registry.Quantity(Decimal(parts[1]), registry.parse_units(powers))
        target = registry.parse_units(unit)
        is_angle = given.to_root_units().units == registry.radian
        converted = float(given.to(target).magnitude)
    except Exception as error:  # pint has errors of every kind, and lets some of others pass
        raise wrong from error
    if (unit == "rad") != is_angle:  # pint takes a per cent for an angle, too
        raise wrong
    return converted


def _comma_hint(text: str) -> str:
    """Return what to do about a decimal comma, "" where there is none."""
    return ", with a decimal point" if re.match(r"\s*[-+]?\d+,\d", text) else ""


def _is_plain_unit(text: str) -> bool:
    """Whether a text can be a unit: pint computes what it is given, as in "m**9**9**9"."""
    return len(text) <= LONGEST_UNIT and not re.search(r"(\*\*|\^)[^A-Za-z]*(\*\*|\^)", text)


@cache
def _registry() -> Any:
    try:
        import pint
    except ImportError as error:
        raise ComputationError(
            f"units cannot be read: {error}; expected the package pint (pip install pint), or bare "
            "numbers in SI units"
        ) from error
    return pint.UnitRegistry(non_int_type=Decimal)
