"""Names of loads and supports, which are parts of the names of a result's variables."""

import re
from typing import Any

from bilayer.errors import InputError
from bilayer.validation import shown

LONGEST_NAME = 40
TAKEN = ("steps",)
"""`load_steps` is a variable of every result."""


def check_name(table: str, name: Any) -> None:
    """Raise InputError unless a name is a word of letters, digits and underscores."""
    if not isinstance(name, str) or not re.fullmatch(rf"[A-Za-z]\w{{0,{LONGEST_NAME - 1}}}", name):
        raise InputError(
            f"{table}.{shown(name)}: expected a name of at most {LONGEST_NAME} letters, digits and "
            "underscores that begins with a letter"
        )
    if name in TAKEN:
        raise InputError(f"{table}.{name}: expected another name, this one has a meaning")
