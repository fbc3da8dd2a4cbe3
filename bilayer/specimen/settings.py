"""Settings of a solver: a frozen dataclass whose fields carry their own documentation.

`setting(1e-8, "tolerance of …")` is the default of a field; `settings_from` reads the
`NAME=VALUE` texts of the command line; `describe` lists them with their defaults.
"""

import dataclasses
import textwrap
from collections.abc import Callable, Iterable, Mapping
from numbers import Real
from typing import Any, TypeVar

import tomli_w

from bilayer.errors import InputError
from bilayer.specimen.overrides import toml_value
from bilayer.validation import finite, nearest, shown

Settings = TypeVar("Settings")

BRANCH_CHOICES = ("lowest", "other", "unstable")
"""Values of the setting `branch`: the branch to follow after a loss of stability."""
CONTACT_CHOICES = ("none", "barrier")
"""Values of the setting `contact`: whether a sheet may pass through itself."""


def setting(default: Any, text: str, not_plain: Callable[[Any], str] | None = None) -> Any:
    """Return a dataclass field with a default and a description, its unit in brackets.

    Parameters
    ----------
    default : Any
        The default.
    text : str
        The description.
    not_plain : callable, optional
        Takes a value and returns the part of it that could do more than compute: run code, or read
        and write files. Returns an empty text if there is none. Left out: no value can.
    """
    return dataclasses.field(default=default, metadata={"text": text, "not_plain": not_plain})


def check_plain(settings: Any) -> None:
    """Raise InputError if a setting could do more than compute; for settings read from a file.

    The text says what would be run.
    """
    for field in dataclasses.fields(settings):
        not_plain = field.metadata.get("not_plain")
        found = "" if not_plain is None else not_plain(getattr(settings, field.name))
        if found:
            raise InputError(
                f"solver.{field.name}: {found!r} could run code or write files, expected plain "
                "options in a file (docs/usage.md lists them); --trust allows it"
            )


def settings_from(kind: type[Settings], values: Mapping[str, Any]) -> Settings:
    """Return the settings of one kind with some of them replaced.

    Parameters
    ----------
    kind : type
        A settings dataclass.
    values : mapping
        New values by field name; a number given as text is read as in TOML.

    Raises
    ------
    InputError
        A name is not one of the fields (with the nearest one), or a value is of another type than
        the default's.
    """
    fields = {field.name: field for field in dataclasses.fields(kind)}  # type: ignore[arg-type]
    for name in values:
        if name not in fields:
            raise InputError(
                f"solver.{name}: unknown setting, expected one of {', '.join(fields)}"
                f"{nearest(name, fields)}"
            )
    return kind(
        **{name: _converted(name, value, fields[name].default) for name, value in values.items()}
    )


def split_solver_settings(overrides: Iterable[str]) -> tuple[dict[str, str], list[str]]:
    """Part `solver.NAME=VALUE` texts, as a mapping, from the other overrides."""
    settings: dict[str, str] = {}
    others = []
    for override in overrides:
        name, _, value = override.partition("=")
        if name.strip().startswith("solver."):
            settings[name.strip().removeprefix("solver.")] = value
        else:
            others.append(override)
    return settings, others


def describe(kind: type) -> str:
    """Return the settings of a class as text: name and default, below them the description.

    Lines are at most 100 letters long.
    """
    lines = []
    for field in dataclasses.fields(kind):
        lines.append(f"  solver.{field.name} = {_shown(field.default)}")
        lines += textwrap.wrap(
            field.metadata.get("text", ""), 100, initial_indent=6 * " ", subsequent_indent=6 * " "
        )
    return "\n".join(lines)


def settings_records(kind: type) -> list[dict[str, Any]]:
    """Return the settings of a class as records: name, default, description."""
    return [
        {"name": field.name, "default": field.default, "text": field.metadata.get("text", "")}
        for field in dataclasses.fields(kind)
    ]


def settings_to_toml(settings: Any) -> str:
    """Return the TOML text of a settings dataclass; a setting of None is left out."""
    table = {key: value for key, value in vars(settings).items() if value is not None}
    return tomli_w.dumps(table)


def _shown(default: Any) -> str:
    """Return a default as one writes it in TOML."""
    return str(default).lower() if isinstance(default, bool) else repr(default)


def _converted(name: str, value: Any, default: Any) -> Any:
    """Return `value` in the type of the setting's default."""
    read = value
    if isinstance(value, str) and not isinstance(default, str):
        read = toml_value(f"solver.{name}", value)
    if isinstance(default, bool) != isinstance(read, bool):
        raise InputError(f"solver.{name} = {shown(value)}: expected {_kind_name(default)}")
    if isinstance(read, Real) and not isinstance(default, bool):
        number = finite(f"solver.{name}", read)
        if isinstance(default, float):
            return number
        if isinstance(default, int) and number.is_integer():
            return int(number)
    if default is not None and not isinstance(read, type(default)):
        raise InputError(f"solver.{name} = {shown(value)}: expected {_kind_name(default)}")
    return read


def _kind_name(default: Any) -> str:
    names = {bool: "true or false", int: "a whole number", float: "a number", str: "a text"}
    return names.get(type(default), type(default).__name__)
