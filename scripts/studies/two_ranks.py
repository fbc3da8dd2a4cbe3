"""The speed-up of a study on two ranks: equal cases of the shell, run in turn.

Wall time is that of the command, with its start and its index; CPU time that of all its processes.
The load average before each run tells whether the machine had two cores to give.

    scripts/env python3 scripts/studies/two_ranks.py [--cases 24] [--runs 3]
"""

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from bilayer.specimen.toml import template

STUDY = """
specimen = "specimen.toml"
solver = "dshell"
[vary]
"mesh.size" = [{size}]
"prestretch.milestones" = [1.06]
"gravity.acceleration" = {{ start = 0.0, stop = 0.1, num = {count} }}
"""
"""The weight hardly changes the work: all cases have one mesh."""
RANKS = (1, 2)


def main() -> int:
    options = _options()
    wall: dict[int, list[float]] = {ranks: [] for ranks in RANKS}
    cpu: dict[int, list[float]] = {ranks: [] for ranks in RANKS}
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "specimen.toml").write_text(template(), encoding="utf-8")
        file = Path(scratch) / "study.toml"
        file.write_text(STUDY.format(size=options.mesh_size, count=options.cases), encoding="utf-8")
        for run in range(options.runs):
            for ranks in RANKS:
                load = os.getloadavg()[0]
                seconds, spent = timed_study(file, Path(scratch) / f"{run}.{ranks}", ranks)
                wall[ranks].append(seconds)
                cpu[ranks].append(spent)
                print(f"{ranks} ranks: {seconds:.1f} s, CPU time {spent / options.cases:.2f} s per "
                      f"case; load average before it {load:.2f}", flush=True)  # fmt: skip
    for what, times in (("wall", wall), ("CPU", cpu)):
        one, two = (np.array(times[ranks]) for ranks in RANKS)
        each = ", ".join(f"{ratio:.2f}" for ratio in two / one)
        print(f"{what} time, two ranks over one: {np.median(two) / np.median(one):.2f} ({each})")
    return 0


def timed_study(file: Path, folder: Path, ranks: int) -> tuple[float, float]:
    """Run the study; return its wall time and the CPU time of all its processes, s."""
    command = ["mpirun", "-n", str(ranks), sys.executable, "-m", "bilayer", "study"]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([*command, str(file), "-o", str(folder), "--quiet"], check=True)
    seconds = time.monotonic() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return seconds, spent


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="One rank and two on the same study.")
    parser.add_argument("--cases", type=int, default=24)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--mesh-size", type=float, default=0.005, metavar="M")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
