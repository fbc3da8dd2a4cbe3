"""What lacks or goes while a run is under way: disk, folder, index; and who else writes there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import psutil

from attack.bench import STUDY, Bench
from attack.child import WITHOUT_LAUNCHER, in_child, load_everything

TESTS = Path(__file__).parents[1]
SOLVE = ("solve", "s.toml", "--solver", "dshell", "-o", "a.nc", "--quiet")
WRITERS: dict[str, tuple[str, ...]] = {
    "solve": SOLVE,
    "mesh": ("mesh", "s.toml", "-o", "m.vtu", "--quiet"),
    "plot": ("plot", "good.nc", "-o", "a.png"),
    "convert": ("convert", "good.nc", "-o", "a.vtu"),
    "export": ("export", "s.toml", "-o", "d.inp", "--quiet"),
    "study": ("study", "study.toml", "-o", "st", "--quiet", "--jobs", "1"),
}
KILOBYTES = (12, 40, 160)  # of which two small files take 8
MANY = 300
GROWTH = 4.0
"""MiB that the process of many cases may grow by after its first fifty."""


@dataclass(frozen=True)
class Condition:
    """What was met, what came of it, and what is wrong with that."""

    what: str
    outcome: str
    wrong: str


def meet_all(bench: Bench, place: Path) -> Iterator[Condition]:
    yield from _full_disks(bench, place)
    yield _two_writers(bench, place)
    yield _two_studies(bench, place)
    yield from _deleted(bench, place)
    yield _folder_deleted_meanwhile(bench, place)
    yield _many_cases(bench, place)


def _folder(bench: Bench, place: Path, name: str) -> Path:
    folder = place / name
    folder.mkdir(parents=True)
    shutil.copy(bench.specimen, folder / "s.toml")
    shutil.copy(bench.result, folder / "good.nc")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return folder


def _started(
    folder: Path, words: Sequence[str], module: Sequence[str] = ("bilayer",)
) -> subprocess.Popen:
    """Start the command line, or a module that starts it."""
    clean = {k: v for k, v in os.environ.items() if not k.startswith(WITHOUT_LAUNCHER)}
    clean["PYTHONPATH"] = f"{TESTS}:{TESTS.parent}"
    command = [sys.executable, "-P", "-m", *module, *words]
    return subprocess.Popen(
        command,
        cwd=folder,
        env=clean,
        text=True,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )


def _ended(running: subprocess.Popen) -> tuple[int, str]:
    _, said = running.communicate(timeout=240)
    return running.returncode, said.strip()


def _handled(status: int, said: str, allowed: Sequence[int]) -> str:
    """Return what is wrong with an exit status and what was said."""
    if "Traceback" in said or status < 0 or status not in allowed:
        return f"exit status {status}: {said[-200:]}"
    lines = said.splitlines()
    if status and (not lines or not all(line.startswith("bilayer") for line in lines)):
        return f"says {said[-200:]!r}"
    return ""


def _full_disks(bench: Bench, place: Path) -> Iterator[Condition]:
    """Yield each verb that writes on disks of a few kilobytes."""
    for verb, words in WRITERS.items():
        for size in KILOBYTES:
            folder = _folder(bench, place, f"{verb}{size}")
            disk = folder / "disk"
            disk.mkdir()
            small = ["attack.small_disk", str(size), str(disk)]
            status, said = _ended(_started(folder, words, small))
            wrong = _handled(status, said, (0, 1, 2))
            left = (folder / "left").read_text(encoding="utf-8").split()
            wrong = wrong or (f"{left[0]} is left behind" if left else "")
            yield Condition(f"{verb} on a disk of {size} kB", f"exit status {status}", wrong)


def _two_writers(bench: Bench, place: Path) -> Condition:
    from bilayer import open_result

    folder = _folder(bench, place, "writers")
    both = [_ended(running) for running in [_started(folder, SOLVE) for _ in range(2)]]
    wrong = "; ".join(filter(None, (_handled(status, said, (0,)) for status, said in both)))
    reached = int(open_result(folder / "a.nc")["converged"].sum())
    left = {path.name for path in folder.iterdir()} - {"s.toml", "good.nc", "study.toml", "a.nc"}
    return Condition("two runs write one file", f"{reached} milestone", wrong or ", ".join(left))


def _two_studies(bench: Bench, place: Path) -> Condition:
    folder = _folder(bench, place, "studies")
    running = [_started(folder, WRITERS["study"]) for _ in range(2)]
    both = sorted(_ended(one) for one in running)
    wrong = _handled(*both[0], (0,)) or _handled(*both[1], (0, 1))
    if not wrong and both[1][0] == 1 and "another study" not in both[1][1]:
        wrong = both[1][1]
    done = (folder / "st/study.log").read_text(encoding="utf-8").count("\tdone\t")
    if not wrong and done != 2:
        wrong = f"{done} cases were computed, not 2"
    return Condition(
        "two studies in one folder", f"exit status {both[0][0]} and {both[1][0]}", wrong
    )


def _deleted(bench: Bench, place: Path) -> Iterator[Condition]:
    for name, again in (("study.csv", 0), ("study.log", 0), ("plan.json", 0), ("cases", 2)):
        folder = place / f"deleted {name}"
        shutil.copytree(bench.study, folder)
        path = folder / "st" / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        log = folder / "st/study.log"
        before = log.read_text(encoding="utf-8").count("\tbegun\t") if log.exists() else 0
        status, said = _ended(_started(folder, WRITERS["study"]))
        begun = (log.read_text(encoding="utf-8").count("\tbegun\t") if log.exists() else 0) - before
        wrong = _handled(status, said, (0,))
        wrong = wrong or ("" if begun == again else f"{begun} cases computed, not {again}")
        wrong = wrong or ("" if (folder / "st/study.csv").exists() else "there is no index")
        yield Condition(f"{name} of a study deleted", f"{begun} cases computed again", wrong)


def _folder_deleted_meanwhile(bench: Bench, place: Path) -> Condition:
    folder = _folder(bench, place, "gone")
    running = _started(folder, WRITERS["study"])
    log = folder / "st/study.log"
    while running.poll() is None and not (log.exists() and "begun" in log.read_text()):
        time.sleep(0.01)
    shutil.rmtree(folder / "st")
    status, said = _ended(running)
    again, words = _ended(_started(folder, WRITERS["study"]))
    wrong = _handled(status, said, (1, 2)) or _handled(again, words, (0,))
    return Condition("the folder of a study deleted while it runs", f"exit status {status}", wrong)


def _many_cases(bench: Bench, place: Path) -> Condition:
    """Compute many cases in one process: its memory and its open files stay."""
    folder = _folder(bench, place, "many")
    angles = ", ".join(f"{0.2 + 0.001 * k:.3f}" for k in range(MANY))
    text = STUDY.replace("[0.3, 0.4]", f"[{angles}]")
    (folder / "study.toml").write_text(text, encoding="utf-8")

    def compute() -> str:
        from bilayer.study.compute import compute_case
        from bilayer.study.folder import StudyFolder
        from bilayer.study.plan import read_study

        os.chdir(folder)
        plan, kept = read_study("study.toml"), StudyFolder("st")
        kept.make()
        process = psutil.Process()
        memory, files = [], []
        for case in plan.cases:
            compute_case(case, kept)
            memory.append(process.memory_info().rss / 2**20)
            files.append(process.num_fds())
        done = len(list(Path("st/cases").glob("*.nc")))
        return f"{done} {memory[49]:.1f} {memory[-1]:.1f} {files[49]} {files[-1]}"

    load_everything()
    told = in_child(compute, seconds=1200)
    try:
        done, early, late, first, last = map(float, told.split())
    except ValueError:
        return Condition(f"{MANY} cases in one process", "", told)
    outcome = f"{early:.1f} MiB after 50, {late:.1f} at the end; {first:.0f} and {last:.0f} files"
    good = done == MANY and late - early < GROWTH and last <= first
    return Condition(
        f"{MANY} cases in one process", outcome, "" if good else "grows, or lacks cases"
    )
