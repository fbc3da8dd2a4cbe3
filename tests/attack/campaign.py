"""The campaign: a choice of attempts, each in a folder of its own, and what was mishandled."""

from __future__ import annotations

import random
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from attack.attempt import Attempt
from attack.bench import Bench
from attack.child import load_everything, run_forked, run_fresh
from attack.judge import complaint, snapshot

CLASSES = {
    "specimen file": "specimen_files",
    "surroundings": "surroundings",
    "override": "overrides",
    "options": "options",
    "result bytes": "result_bytes",
    "result structure": "result_structure",
    "study file": "study_files",
    "study folder": "study_folders",
    "mesh file": "mesh_files",
    "frd file": "frd_files",
    "drawing file": "drawing_files",
    "material test": "measurement_files",
    "design file": "design_files",
    "output": "outputs",
    "environment": "environment",
    "text": "texts",
    "trust": "trust",
}
"""The module of each class of inputs."""
SHARE_OF_FRESH = 50
"""One of so many inputs of a choice may need a process of its own."""


@dataclass(frozen=True)
class Verdict:
    """An attempt, what was wrong with its outcome (or nothing), and the seconds it took."""

    attempt: Attempt
    wrong: str
    seconds: float
    said: str


def choose(
    bench: Bench, seed: int, classes: Sequence[str], count: int | None, quick: bool
) -> list[Attempt]:
    """Return the attempts of some classes; if a number is told, that many, the same for each seed.

    The quick choice takes none that need a process of their own.
    """
    made = {name: _all_of(bench, seed, name, quick) for name in classes}
    if count is None:
        return [attempt for attempts in made.values() for attempt in attempts]
    for name, attempts in made.items():
        slow = [attempt for attempt in attempts if attempt.fresh]
        few = min(len(slow), count // SHARE_OF_FRESH)
        kept = random.Random(f"{seed} {name} fresh").sample(slow, few)
        made[name] = [attempt for attempt in attempts if not attempt.fresh] + kept
    chosen: list[Attempt] = []
    left = list(made)
    while left:  # the smallest class first: what it lacks goes to the others
        name = min(left, key=lambda name: len(made[name]))
        share = min(len(made[name]), round((count - len(chosen)) / len(left)))
        chosen += random.Random(f"{seed} {name} choice").sample(made[name], share)
        left.remove(name)
    return chosen


def _all_of(bench: Bench, seed: int, name: str, quick: bool) -> list[Attempt]:
    module = import_module(f"attack.{CLASSES[name]}")
    attempts = module.attempts(bench, random.Random(f"{seed} {name}"))
    return [attempt for attempt in attempts if not (quick and attempt.fresh)]


def run(bench: Bench, chosen: Sequence[Attempt], place: Path) -> Iterator[Verdict]:
    """Run attempts one after the other; yield what came of each."""
    load_everything()
    for number, attempt in enumerate(chosen):
        yield _try(bench, attempt, place / f"{number}")


def _try(bench: Bench, attempt: Attempt, place: Path) -> Verdict:
    folder, home, scratch = place / "w", place / "h", place / "t"
    for made in (folder, home, scratch):
        made.mkdir(parents=True)
    attempt.lay_out(folder)
    variables: dict[str, str | None] = {
        "HOME": str(home),
        "TMPDIR": str(scratch),
        "XDG_CACHE_HOME": str(bench.cache),
        **attempt.variables,
    }
    before = snapshot(place)
    command: Callable = run_fresh if attempt.fresh else run_forked
    ended = command(attempt.words, folder, variables, attempt.streams, attempt.limits)
    after = snapshot(place)
    wrong = complaint(attempt, ended, _shown(before), _shown(after), folder)
    shutil.rmtree(place, ignore_errors=True)
    return Verdict(attempt, wrong, ended.seconds, (ended.stderr or ended.stdout)[:400])


def _shown(found: dict[str, str]) -> dict[str, str]:
    """Name what lies in the folder from there, the rest from outside."""
    return {
        name.removeprefix("w/") if name.startswith("w/") else f"../{name}": what
        for name, what in found.items()
        if name != "w" and not _is_of_a_library(name)
    }


def _is_of_a_library(name: str) -> bool:
    """Whether a name is that of a folder of Open MPI's session, or one that libraries keep at home.

    These are gmsh's window toolkit, matplotlib's settings (an empty folder) and fontconfig's list
    of fonts, which it keeps there where there is no folder for caches.
    """
    parts = Path(name).parts
    of_mpi = parts[-1].startswith(("ompi.", "prte", "pmix")) or "/ompi." in name
    of_matplotlib = parts[-1] == ".config" or parts[-2:] == (".config", "matplotlib")
    return of_mpi or of_matplotlib or ".fltk" in parts or ".fontconfig" in parts
