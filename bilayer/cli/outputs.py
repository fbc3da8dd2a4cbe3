"""The gate of every output of the command line, passed before anything is computed.

It knows the inputs: all files that the other arguments name, and those that the specimen or study
file names in turn.
"""

import argparse
import os
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from bilayer.errors import InputError
from bilayer.runtime.input_file import read_text
from bilayer.runtime.terminal import tell
from bilayer.specimen.toml_text import parse_toml

SEPARATORS = tuple(filter(None, (os.sep, os.altsep)))
Check = Callable[[str | Path, Iterable[str | Path]], Any]
"""`bilayer.runtime.output_file.check_writable`, or one that knows the format, too."""


def check_output(
    options: argparse.Namespace, check: Check, names: Iterable[str | Path] | None = None
) -> None:
    """Raise InputError unless the output of a verb can be written, and is none of its inputs.

    Parameters
    ----------
    options : Namespace
        Of the verb; its `output` may be None.
    check : callable
        Of this kind of file.
    names : iterable of path-like, optional
        The files that are written, if they are others than `output`.
    """
    if options.output is None and names is None:
        return
    if options.output is not None and options.output.endswith(SEPARATORS):
        raise InputError(f"--output {options.output}: ends as a folder, expected a file name")
    inputs = list(input_files(options))
    for name in [options.output] if names is None else names:
        check(name, inputs)
        if Path(name).suffix == ".nc" and Path(name).is_file():
            options.replaced = [*getattr(options, "replaced", []), str(name)]


def output_beside(options: argparse.Namespace, source: str, ending: str) -> Path:
    """Return the output of a verb: as given, else beside a file that it reads, by its stem.

    Raises
    ------
    InputError
        There is a file of the name that was not given, and the user has not said what of it:
        neither `--overwrite` nor `--resume`.
    """
    if options.output is not None:
        return Path(options.output)
    output = Path(source).with_suffix(ending)
    may = options.overwrite or getattr(options, "resume", False)
    if output.exists() and not may:
        raise InputError(
            f"output file {output}: is there already, expected --overwrite to replace it"
            f"{', --resume to go on with it' if 'resume' in options else ''} or another as -o FILE"
        )
    return output


def tell_replaced(options: argparse.Namespace) -> None:
    """Say which results a verb has replaced: those that its gate has seen and that are new now.

    A result may be hours of computing. Pictures and meshes are drawn again in seconds; of those
    nothing is said.
    """
    if options.quiet or getattr(options, "resume", False):
        return
    for name in dict.fromkeys(getattr(options, "replaced", [])):
        tell(f"bilayer: {name}: replaced the file that was there")


def input_files(options: argparse.Namespace) -> Iterator[Path]:
    """Yield the files that a verb reads."""
    for field, value in vars(options).items():
        if field not in ("output", "replaced"):
            for word in _texts(value):
                yield from _file_and_those_it_names(word, Path())


def _file_and_those_it_names(word: str, folder: Path) -> Iterator[Path]:
    """Yield a file and, if it is TOML, those that it names relative to its folder."""
    path = folder / word
    try:
        if not word or not path.is_file():
            return
    except (OSError, ValueError):  # no name of a file
        return
    yield path
    if path.suffix == ".toml":
        for inner in _texts(_tables(path)):
            if inner != path.name:
                yield from _file_and_those_it_names(inner, path.parent)


def _tables(path: Path) -> Any:
    """Return what a file holds; nothing if it is damaged, which its reader will tell."""
    try:
        return parse_toml(read_text(path, "file"), str(path))
    except InputError:
        return {}


def _texts(value: Any) -> Iterator[str]:
    """Yield all texts in a value."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        for inner in value.values():
            yield from _texts(inner)
    elif isinstance(value, (list, tuple)):
        for inner in value:
            yield from _texts(inner)
