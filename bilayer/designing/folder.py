"""The folder of a design: all that was computed, so that a run that was killed goes on.

design.json           which task it is of
stage-1/mesh.npz      the planar mesh of a stage of the search, and where the stage begins
stage-1/0001.npz      an evaluation; whole, because it is moved there when it is complete

The search depends on nothing but its evaluations. A run that is started again takes those that are
there, in their order, and computes the rest: it ends as the first one would have.
"""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError, NotResumableError
from bilayer.runtime.input_file import name_of_open_file, open_input, read_text
from bilayer.runtime.output_file import remove_leftovers, whole_file
from bilayer.runtime.system import hold_lock, lock_alone

LARGEST = 2**31
LOCK = ".lock"
Arrays = Mapping[str, NDArray[Any]]


class DesignFolder:
    """The files of a design.

    Parameters
    ----------
    path : path-like
        The folder, made if it is missing.

    Raises
    ------
    InputError
        It cannot be made, or is a file.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            reason = error.strerror or error
            raise InputError(f"design folder {path}: cannot be made ({reason})") from error

    @contextmanager
    def lock(self) -> Iterator[None]:
        """Hold the folder for one run at a time.

        Raises
        ------
        ComputationError
            Another one runs in it.
        """
        with hold_lock(self.path / LOCK, lock_alone) as held:
            if not held:
                raise ComputationError(
                    f"design folder {self.path}: another run is in it; end that one, or wait for it"
                )
            yield

    def claim(self, identity: str) -> None:
        """Say which task the folder is of; InputError if it is another one's."""
        file = self.path / "design.json"
        if file.exists():
            try:
                held = json.loads(read_text(file, "design record")).get("task")
            except (ValueError, AttributeError) as error:
                raise NotResumableError(f"{file}: is no record of a design") from error
            if held != identity:
                raise InputError(
                    f"design folder {self.path}: holds another design, expected an empty one or "
                    "that of this file"
                )
            return
        with whole_file(file, "design record") as written:
            written.write_text(json.dumps({"task": identity}) + "\n", encoding="utf-8")

    def stage(self, number: int) -> Path:
        """Return the folder of a stage, from 1, made if it is missing."""
        folder = self.path / f"stage-{number}"
        folder.mkdir(exist_ok=True)
        return folder

    def write(self, file: Path, arrays: Arrays) -> None:
        """Write arrays to a file, whole or not at all."""
        remove_leftovers(file)
        with whole_file(file, "design file") as written:
            np.savez(written, **arrays)  # type: ignore[arg-type]

    def read(self, file: Path) -> Arrays | None:
        """Return the arrays of a file, None if it is not there.

        Raises
        ------
        NotResumableError
            It is damaged.
        """
        if not file.exists():
            return None
        try:
            with (
                open_input(file, "design file", LARGEST) as descriptor,
                np.load(name_of_open_file(descriptor, file), allow_pickle=False) as arrays,
            ):
                return {name: arrays[name] for name in arrays.files}
        except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
            raise NotResumableError(
                f"{file}: is damaged ({error}), expected a file of this design; remove it to "
                "compute it again"
            ) from error
