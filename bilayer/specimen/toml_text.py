"""TOML text as tables, whatever stands in it: what the library cannot read is an InputError.

Every text of a user's file or option goes through here.
"""

import re
import sys
import tomllib
from collections.abc import Mapping
from typing import Any

from bilayer.errors import InputError

DEEPEST = 12
"""Tables and lists within each other; the polygons of a pattern take six."""
LONGEST = 20_000_000
"""Letters; the outline of a scanned drawing takes a few hundred thousand."""
_PART = r"(?<![\w\"'-])[\"']?[\w-]{1,200}[\"']?[ \t]*\."
_KEY = re.compile(r"""("[^"\n]*"|'[^'\n]*'|[\w.-]+)[ \t]*=""")
_LONG_NAME = re.compile(rf"(?:{_PART}[ \t]*){{{2 * DEEPEST}}}")


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """Return the tables of a TOML text.

    Parameters
    ----------
    text : str
        What was written.
    source : str
        Where, for the message.

    Raises
    ------
    InputError
        It is no TOML, too long, nested too deeply, or holds a number of thousands of digits.
    """
    if len(text) > LONGEST:
        raise InputError(
            f"{source}: has {len(text)} letters, expected a TOML file of at most {LONGEST}"
        )
    if _LONG_NAME.search(text):  # its library takes the square of the number of parts
        raise InputError(f"{source}: a name has more than {2 * DEEPEST} parts, {_EXPECTED}")
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{source}: {_TOO_DEEP}") from None
    except tomllib.TOMLDecodeError as error:
        hint = _hint(text, str(error))
        raise InputError(f"{source}: not a valid TOML file ({error}){hint}") from error
    except ValueError:  # of Python itself, for a number
        raise InputError(f"{source}: {_long_number(text)}") from None
    _check_depth(tables, source)
    return tables


_SLIPS = (
    (
        re.compile(r"[^=#]*=\s*([-+]?\d+),\s*(\d+)"),
        "a decimal point, not a comma: {0}.{1} (if two values are meant, brackets: [{0}, {1}])",
    ),
    (
        re.compile(r"\s*([A-Za-z_]+) +([A-Za-z_]+) *="),
        "a key without spaces, such as {0}_{1}",
    ),
    (
        re.compile(r"[^=#]*=\s*([A-Za-z][\w-]*)\s*(?:#|$)"),
        'quotes around a text: "{0}"',
    ),
    (
        re.compile(r"[^=#]*=\s*([-+]?[\d.]+ ?[A-Za-z%][\w/^]*)"),
        'quotes around a value with a unit: "{0}"',
    ),
)
"""What a line looks like in which a frequent slip was made, and what was expected."""


def _hint(text: str, error: str) -> str:
    """Return what to do about a frequent slip in the line that an error names, or ""."""
    found = re.search(r"at line (\d{1,9})", error)
    lines = text.split("\n")
    line = lines[int(found[1]) - 1][:200] if found and int(found[1]) <= len(lines) else ""
    for slip, expected in _SLIPS:
        if match := slip.match(line):
            return f", expected {expected.format(*match.groups())}"
    return ""


def _long_number(text: str) -> str:
    """Return what is wrong with a text that has a number of more digits than Python reads."""
    most = sys.get_int_max_str_digits()
    number = next(run for run in re.finditer(r"[\d_]+", text) if len(run[0]) > most)
    begin = text.rfind("\n", 0, number.start()) + 1
    line = text.count("\n", 0, begin) + 1
    keys = _KEY.findall(text, begin, number.start())
    key = f", {keys[-1][:100]}" if keys else ""
    return f"line {line}{key}: a number of {len(number[0])} digits, expected at most {most}"


_EXPECTED = f"expected at most {DEEPEST} tables and lists within each other"
_TOO_DEEP = f"is nested too deeply, {_EXPECTED}"


def _check_depth(tables: Any, source: str) -> None:
    """Raise InputError if tables and lists are nested too deeply for those who go through them."""
    level = [tables]
    for _ in range(DEEPEST):
        level = [part for holder in level for part in _parts(holder)]
        if not level:
            return
    raise InputError(f"{source}: {_TOO_DEEP}")


def _parts(holder: Any) -> list[Any]:
    values = holder.values() if isinstance(holder, Mapping) else holder
    return [value for value in values if isinstance(value, (Mapping, list))]
