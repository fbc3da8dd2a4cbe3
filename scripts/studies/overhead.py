"""The overhead of a study: time per case, and memory over many cases in one process.

scripts/env python3 scripts/studies/overhead.py [--cases 1000]
scripts/env python3 scripts/studies/overhead.py --solver fenics --cases 40
"""

import argparse
import sys
import tempfile
import time
from functools import partial
from pathlib import Path

import numpy as np
import psutil

from bilayer.specimen.toml import template
from bilayer.study.compute import compute_case
from bilayer.study.folder import StudyFolder
from bilayer.study.index import write_index
from bilayer.study.plan import read_study

STUDY = """
specimen = "specimen.toml"
solver = "{solver}"
[settings.{solver}]
{settings}
[vary]
"mesh.size" = [0.02]
"prestretch.milestones" = [1.01]
"cut.cutout_angle" = {{ start = 0.3, stop = 0.5, num = {count} }}
"""
SETTINGS = {"dshell": 'model = "paper"\ntotal_time = 0.001', "fenics": "flow_steps = 0"}
SAMPLES = 10


def main() -> int:
    parser = argparse.ArgumentParser(description="Overhead of a study: time and memory.")
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--solver", choices=SETTINGS, default="dshell")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        measure(Path(scratch), options.solver, options.cases)
    return 0


def measure(scratch: Path, solver: str, count: int) -> None:
    """Compute tiny cases in this process; print the time beside the solver's, and memory."""
    (scratch / "specimen.toml").write_text(template(), encoding="utf-8")
    (scratch / "study.toml").write_text(
        STUDY.format(solver=solver, settings=SETTINGS[solver], count=count), encoding="utf-8"
    )
    planned, plan = _timed(partial(read_study, scratch / "study.toml"))
    folder = StudyFolder(scratch / "out")
    folder.make()
    folder.keep_plan(plan)
    process, memory = psutil.Process(), []
    spent = 0.0
    every = max(count // SAMPLES, 1)
    for number, case in enumerate(plan.cases, start=1):
        seconds, _ = _timed(partial(compute_case, case, folder))
        spent += seconds
        if number % every == 0:
            memory.append(process.memory_info().rss / 2**20)
            print(f"{number:5d} cases: {memory[-1]:.1f} MiB", flush=True)
    indexed, index = _timed(partial(write_index, folder))
    solved = index["case_seconds"].sum()
    costs = {
        "solver": solved / count,
        "beside it": (spent - solved) / count,
        "plan": planned / count,
        "index": indexed / count,
    }
    words = ", ".join(f"{name} {1e3 * cost:.1f} ms" for name, cost in costs.items())
    print(f"time per case: {words}")
    slope = np.polyfit(np.arange(len(memory)), memory, 1)[0] / every
    print(f"memory grows by {1024 * slope:.2f} KiB per case")


def _timed(action):
    start = time.perf_counter()
    outcome = action()
    return time.perf_counter() - start, outcome


if __name__ == "__main__":
    sys.exit(main())
