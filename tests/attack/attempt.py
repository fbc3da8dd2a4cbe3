"""One attempt: files in an empty folder, the words of a command, and what is right."""

from __future__ import annotations

import enum
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Content = str | bytes | Path | Callable[[Path], Any]
"""Of a file: its text, its bytes, a file or folder to copy, or what makes it at the path given."""


class Right(enum.Enum):
    """What is right for an input."""

    REFUSED = "refused: exit status 2, one line, nothing left behind"
    ACCEPTED = "accepted: exit status 0, the output is there, nothing else"
    EITHER = "refused or accepted"
    HANDLED = "refused, accepted, or exit status 1 with a line each of what went wrong"


@dataclass(frozen=True)
class Attempt:
    """An input and what is right for it.

    Parameters
    ----------
    kind : str
        The class of inputs.
    name : str
        What is odd about it; with the kind it is its own.
    words : sequence of str
        Of the command line.
    files : mapping of str to Content
        What lies in the folder before, by name.
    right : Right
        What is right.
    outputs : sequence of str
        Patterns of the names that an accepted input may make or change.
    makes : sequence of str
        Names of the files that it has to make.
    says : str
        Regular expression that is found in what is said on stderr of a refusal.
    says_not : str
        One that is found neither there nor on stdout.
    check : callable
        Called with the folder afterwards, and what was printed, if the input was accepted; returns
        what is wrong, or an empty text.
    refused_check : callable
        The same, called if it was refused.
    variables : mapping
        Environment variables; None removes one.
    fresh : bool
        Run in a process of its own from the start, not a forked one.
    streams : mapping
        File descriptor to "closed", or to a path that it is opened on.
    limits : mapping
        Resource limits, by their number in `resource`.
    """

    kind: str
    name: str
    words: Sequence[str]
    files: Mapping[str, Content] = field(default_factory=dict)
    right: Right = Right.REFUSED
    outputs: Sequence[str] = ()
    makes: Sequence[str] = ()
    says: str = ""
    says_not: str = ""
    check: Callable[[Path, str], str] | None = None
    refused_check: Callable[[Path, str], str] | None = None
    variables: Mapping[str, str | None] = field(default_factory=dict)
    fresh: bool = False
    streams: Mapping[int, str] = field(default_factory=dict)
    limits: Mapping[int, int] = field(default_factory=dict)

    def lay_out(self, folder: Path) -> None:
        """Make the files in a folder."""
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if isinstance(content, str):
                path.write_bytes(content.encode())
            elif isinstance(content, bytes):
                path.write_bytes(content)
            elif isinstance(content, Path):
                (shutil.copytree if content.is_dir() else shutil.copy)(content, path)
            else:
                content(path)
