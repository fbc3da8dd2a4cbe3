"""TOML text of tables with values that a TOML writer would refuse."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import tomli_w


@dataclass(frozen=True)
class Raw:
    """A value that is written as it is."""

    text: str


def fragment(value: Any) -> str:
    """Return a value as it stands behind `key = `."""
    if isinstance(value, Raw):
        return value.text
    if isinstance(value, Mapping):
        pairs = (f"{_key(key)} = {fragment(item)}" for key, item in value.items())
        return "{ " + ", ".join(pairs) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(fragment, value)) + "]"
    if isinstance(value, int) and not isinstance(value, bool):
        return str(value)
    return tomli_w.dumps({"k": value}).partition("=")[2].strip()


def document(tables: Mapping[str, Any]) -> str:
    """Return a file of tables; lists of tables are written in line."""
    simple = [f"{_key(k)} = {fragment(v)}" for k, v in tables.items() if not isinstance(v, Mapping)]
    parts = ["\n".join(simple)]
    for name, content in tables.items():
        if isinstance(content, Mapping):
            lines = (f"{_key(key)} = {fragment(value)}" for key, value in content.items())
            parts.append(f"[{_key(name)}]\n" + "\n".join(lines))
    return "\n".join(parts) + "\n"


def _key(name: str) -> str:
    return fragment(str(name))
