"""Two studies killed at random moments and resumed: the same files, nothing computed twice.

60 cases of the shell and 6 of the finite elements, under `mpirun -n 2`, each killed with SIGKILL
three times, are held against the same studies left alone. Exit status 1 if anything differs.

    scripts/env python3 scripts/studies/kill_and_resume.py [--cases 60 6] [--seed 1]
"""

import argparse
import contextlib
import random
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import pandas as pd
import psutil

from bilayer.specimen.toml import template
from bilayer.study.index import TIMINGS

RANKS = 2
KILLS = 3
STUDY = """
specimen = "specimen.toml"
solver = "{solver}"
[vary]
"mesh.size" = [{size}]
"prestretch.milestones" = [1.03]
"cut.cutout_angle" = {{ start = 0.3, stop = 0.5, num = {count} }}
"""
SIZES = {"dshell": 0.01, "fenics": 0.012}


def main() -> int:
    options = _options()
    chance = random.Random(options.seed)
    good = True
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "specimen.toml").write_text(template(), encoding="utf-8")
        for (solver, size), count in zip(SIZES.items(), options.cases, strict=True):
            file = Path(scratch) / f"{solver}.toml"
            file.write_text(STUDY.format(solver=solver, size=size, count=count), encoding="utf-8")
            good &= survives(file, count, chance)
    return 0 if good else 1


def survives(file: Path, count: int, chance: random.Random) -> bool:
    """Run one study alone and once killed and resumed; print and return whether all is the same."""
    alone, killed = file.with_suffix(".alone"), file.with_suffix(".killed")
    start = time.monotonic()
    finish(file, alone)
    whole = time.monotonic() - start
    for _ in range(KILLS):
        kill(file, killed, after=chance.uniform(0.1, 0.45) * whole)
    finish(file, killed)
    log = pd.read_csv(
        killed / "study.log", sep="\t", usecols=range(3), names=["t", "event", "case"]
    )
    done = Counter(log["case"][log["event"] == "done"])
    begun = int((log["event"] == "begun").sum())
    left, right = (_without_timings(folder) for folder in (alone, killed))
    apart = [name for name in left if not left[name].equals(right.get(name))]
    checks = {
        "the same files": _files(alone) == _files(killed) and len(_files(killed)) == count,
        f"an index identical but for the timings{_named(apart)}": left.equals(right),
        "no case computed twice": max(done.values()) == 1,
    }
    print(f"{file.stem}: {count} cases, {whole:.0f} s undisturbed; killed {KILLS} times: {begun} "
          f"begun, {sum(done.values())} logged as done")  # fmt: skip
    for what, holds in checks.items():
        print(f"  {what}: {'yes' if holds else 'NO'}", flush=True)
    return all(checks.values())


def start_study(file: Path, folder: Path) -> subprocess.Popen[bytes]:
    command = ["mpirun", "-n", str(RANKS), sys.executable, "-m", "bilayer", "study"]
    words = [*command, str(file), "-o", str(folder), "--quiet"]
    return subprocess.Popen(words)


def finish(file: Path, folder: Path) -> None:
    status = start_study(file, folder).wait()
    if status != 0:
        raise SystemExit(f"the study {file} ended with status {status}")


def kill(file: Path, folder: Path, after: float) -> None:
    """Start the study and end mpirun and its ranks, all at once, with SIGKILL."""
    running = start_study(file, folder)
    time.sleep(after)
    launcher = psutil.Process(running.pid)
    for process in [launcher, *launcher.children(recursive=True)]:
        with contextlib.suppress(psutil.NoSuchProcess):
            process.kill()
    running.wait()


def _files(folder: Path) -> set[str]:
    return {path.name for path in (folder / "cases").iterdir()}


def _named(columns: list[str]) -> str:
    """Name the columns that differ; `git_commit` does if the checkout has changed meanwhile."""
    return f" (apart: {', '.join(columns)})" if columns else ""


def _without_timings(folder: Path) -> pd.DataFrame:
    return pd.read_csv(folder / "study.csv").drop(columns=list(TIMINGS))


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Studies that are killed and resumed.")
    parser.add_argument("--cases", type=int, nargs=2, default=[60, 6], metavar=("SHELL", "FE"))
    parser.add_argument("--seed", type=int, default=1, help="of the moments of the kills")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
