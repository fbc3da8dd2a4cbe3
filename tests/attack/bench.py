"""Good inputs, made once: a result, a mesh in several formats, a finished study, a deck's run."""

from __future__ import annotations

import copy
import shutil
from contextlib import redirect_stdout
from functools import cached_property
from io import StringIO
from pathlib import Path
from typing import Any

from attack.toml_text import document

SIZE = 0.02


class Bench:
    """A folder of good inputs, each made when it is first asked for.

    Parameters
    ----------
    folder : Path
        Where they are kept; not changed by any attempt.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cache = folder / "cache"
        self.cache.mkdir(parents=True)

    @cached_property
    def specimen(self) -> Path:
        """The specimen file of the results: the disc with five cutouts."""
        from attack.specimen_files import SHORT

        path = self.folder / "s.toml"
        path.write_text(document(SHORT), encoding="utf-8")
        return path

    @cached_property
    def uncut(self) -> Path:
        """The specimen file of the same disc without cutouts."""
        from attack.specimen_files import SHORT

        tables: Any = copy.deepcopy(SHORT)
        del tables["cut"]
        path = self.folder / "uncut.toml"
        path.write_text(document(tables), encoding="utf-8")
        return path

    @cached_property
    def result(self) -> Path:
        """A result of two milestones."""
        path = self.folder / "good.nc"
        run(
            "solve",
            self.specimen,
            "--solver",
            "dshell",
            "--prestretch",
            "1.001",
            "1.002",
            "-o",
            path,
            "--quiet",
        )
        return path

    @cached_property
    def unfinished(self) -> Path:
        """The file of a run that was interrupted after its first milestone."""
        import bilayer

        path = self.folder / "unfinished.nc"
        specimen = bilayer.read_specimen(self.specimen).with_milestones([1.001, 1.002])

        def interrupt(step: Any) -> None:
            if step.is_at_target:
                raise KeyboardInterrupt

        try:
            bilayer.solve(specimen, "dshell", observers=[interrupt], output=path)
        except KeyboardInterrupt:
            return path
        raise AssertionError("the run was not interrupted")

    @cached_property
    def study(self) -> Path:
        """A folder: specimen, study file, and the finished study `st` of two cases."""
        folder = self.folder / "study"
        folder.mkdir()
        shutil.copy(self.specimen, folder / "s.toml")
        (folder / "study.toml").write_text(STUDY, encoding="utf-8")
        for number in (1, 2):
            run("study", folder / "study.toml", "-o", folder / "st", "--case", number, "--quiet")
        return folder

    @cached_property
    def deck(self) -> Path:
        """A folder: the deck of the uncut disc, and what a run of it would write."""
        from attack.frd_files import write_run

        folder = self.folder / "deck"
        folder.mkdir()
        run("export", self.uncut, "--prestretch", "1.03", "-o", folder / "deck.inp", "--quiet")
        write_run(folder / "deck.inp", folder / "deck")
        return folder


STUDY = """
specimen = "s.toml"
solver = "dshell"
[settings.dshell]
model = "paper"
total_time = 0.002
[vary]
"cut.cutout_angle" = [0.3, 0.4]
"""


def run(*words: Any) -> None:
    """Run the command line in this process; it has to succeed."""
    from bilayer.cli.main import main

    with redirect_stdout(StringIO()):
        status = main([str(word) for word in words])
    if status != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: exit status {status}")
