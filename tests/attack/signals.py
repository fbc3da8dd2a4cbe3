"""Ctrl-C, SIGTERM and SIGKILL at placed moments: what was reached is kept, and the run goes on.

Every run is started as a user does, in a process of its own, which signals itself (or its group, as
a terminal does, or the mpirun that started it) at the moment. Then it is started again.
"""

from __future__ import annotations

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from attack.bench import Bench
from attack.child import WITHOUT_LAUNCHER

TESTS = Path(__file__).parents[1]
LIMIT = 240
"""Seconds after which a run hangs."""
STATUS = {signal.SIGINT: 130, signal.SIGTERM: 143}
FE = ("--solver", "fenics", "--mesh-size", "0.02")
SHELL = ("--solver", "dshell", "--mesh-size", "0.01")
SOLVE = ("solve", "s.toml", "-o", "a.nc", "--quiet", "--prestretch", "1.01", "1.02", "1.01")
STUDY = ("study", "study.toml", "-o", "st", "--quiet", "--jobs", "2")
RUNS: dict[str, tuple[str, ...]] = {
    "shell": (*SOLVE, *SHELL),
    "FE": (*SOLVE, *FE),
    "FE on 2 ranks": (*SOLVE, *FE),
    "study": STUDY,
    "task of a study": (*STUDY[:-2], "--case", "1"),
}
STUDY_FILE = """
specimen = "s.toml"
solver = "dshell"
[vary]
"mesh.size" = [0.01]
"cut.cutout_angle" = { start = 0.3, stop = 0.5, num = 6 }
"prestretch.milestones" = [1.01, 1.02]
"""


@dataclass(frozen=True)
class Moment:
    """A moment of a run: while a module is loaded, or at a call of a function."""

    run: str
    what: str
    module: str = ""
    function: str = ""
    call: int = 1

    @property
    def place(self) -> dict[str, Any]:
        """As `attack.placed` takes it."""
        if self.module:
            return {"module": self.module}
        return {"function": self.function, "call": self.call}


WRITE = "bilayer.results.files:write_result"
MEASURE = "bilayer.measures.milestone:measure"
MOMENTS = (
    Moment("shell", "loading the command line", module="bilayer.cli.main"),
    Moment("shell", "loading numpy", module="numpy"),
    Moment("shell", "loading xarray", module="xarray"),
    Moment("shell", "loading the shell", module="dshell.solver"),
    Moment("shell", "loading gmsh", module="gmsh"),
    Moment("shell", "reading the specimen", function="bilayer.specimen.toml:read_specimen"),
    Moment("shell", "meshing", function="bilayer.mesh.generation:generate_mesh"),
    Moment("shell", "gmsh begins", function="bilayer.mesh.gmsh_session:gmsh_session"),
    Moment("shell", "solving, 1", function="dshell.solve.newton:EquilibriumSolver._iterate"),
    Moment(
        "shell", "solving, 4", function="dshell.solve.newton:EquilibriumSolver._iterate", call=4
    ),
    Moment(
        "shell", "solving, 7", function="dshell.solve.newton:EquilibriumSolver._iterate", call=7
    ),
    Moment("shell", "measuring, 1", function=MEASURE),
    Moment("shell", "measuring, 2", function=MEASURE, call=2),
    Moment("shell", "writing, 1", function=WRITE),
    Moment("shell", "writing, 2", function=WRITE, call=2),
    Moment("shell", "writing, the last", function=WRITE, call=3),
    Moment("FE", "loading dolfinx", module="dolfinx"),
    Moment("FE", "solving, 1", function="fenics_model.solve.newton:Newton._iterate"),
    Moment("FE", "factorising, 2", function="fenics_model.solve.newton:Newton._factorise", call=2),
    Moment("FE", "solving, 3", function="fenics_model.solve.newton:Newton._iterate", call=3),
    Moment("FE", "measuring, 2", function=MEASURE, call=2),
    Moment("FE", "writing, 2", function=WRITE, call=2),
    Moment("FE on 2 ranks", "meshing", function="bilayer.mesh.generation:generate_mesh"),
    Moment(
        "FE on 2 ranks", "solving, 3", function="fenics_model.solve.newton:Newton._iterate", call=3
    ),
    Moment("FE on 2 ranks", "writing, 2", function=WRITE, call=2),
    Moment("study", "loading the study", module="bilayer.study.run"),
    Moment("study", "its plan", function="bilayer.study.folder:StudyFolder.keep_plan"),
    Moment("study", "computing", function="bilayer.study.processes:wait", call=2),
    Moment("study", "the index", function="bilayer.study.index:write_index"),
    Moment("task of a study", "writing, 2", function=WRITE, call=2),
)
"""Thirty moments of imports, meshing, solving, measuring, writing."""
KILLS = (
    Moment("study", "loading the study", module="bilayer.study.run"),
    Moment("study", "its folder", function="bilayer.study.folder:StudyFolder.make"),
    Moment("study", "writing the plan", function="pathlib:Path.write_text"),
    Moment("study", "computing", function="bilayer.study.processes:wait", call=2),
    Moment("study", "computing, later", function="bilayer.study.processes:wait", call=4),
    Moment("study", "the index", function="bilayer.study.index:write_index"),
    Moment("study", "writing the index", function="pandas:DataFrame.to_csv"),
    Moment("task of a study", "writing, 2", function=WRITE, call=2),
    Moment(
        "task of a study",
        "keeping the result",
        function="bilayer.study.folder:StudyFolder.keep_result",
    ),
)
"""Nine moments of a study at which it is killed."""


@dataclass(frozen=True)
class Report:
    """What came of a signal at a moment; `wrong` is empty if all is right."""

    moment: str
    signal: str
    reached: int
    kept: int
    status: int
    wrong: str


class Runs:
    """Runs in folders of their own, beside the undisturbed ones.

    Parameters
    ----------
    bench : Bench
        Has the specimen.
    place : Path
        Where the folders are made.
    """

    def __init__(self, bench: Bench, place: Path) -> None:
        self._bench, self._place = bench, place
        self._undisturbed: dict[str, Path] = {}

    def strike(self, moment: Moment, number: signal.Signals) -> Report:
        """Run up to a moment, signal, look what is kept, run on, compare."""
        folder = self._folder("struck")
        log = folder.parent / "log"
        to = {"FE on 2 ranks": "parent", "study": "group"}.get(moment.run, "self")
        if number == signal.SIGTERM and moment.run == "study":
            to = "self"
        place = {**moment.place, "number": int(number), "to": to, "log": str(log)}
        status, said = self._run(moment.run, folder, json.dumps(place))
        words = log.read_text(encoding="utf-8").split("\n") if log.exists() else []
        reached = sum(word.startswith("milestone") for word in words)
        kept = self._kept(moment.run, folder)
        wrong = "" if "struck" in words else "the moment never came"
        wrong = wrong or self._ending(moment, number, status, said)
        if not wrong and kept < reached:
            wrong = f"{kept} of {reached} milestones are kept"
        wrong = wrong or self._goes_on(moment.run, folder)
        shutil.rmtree(folder.parent)
        return Report(f"{moment.run}: {moment.what}", number.name, reached, kept, status, wrong)

    def kill_at_random(self, seconds: float) -> Report:
        """Kill a study and all its processes after some seconds; look, run on, compare."""
        folder = self._folder("killed")
        running = self._started("study", folder, None)
        time.sleep(seconds)
        before = self._finished(folder)
        os.killpg(running.pid, signal.SIGKILL)
        running.communicate()
        after = self._finished(folder)
        wrong = "" if set(before) <= set(after) else "a finished case is gone"
        wrong = wrong or self._goes_on("study", folder)
        if not wrong and any(self._finished(folder)[case] != when for case, when in after.items()):
            wrong = "a finished case was computed again"
        shutil.rmtree(folder.parent)
        return Report(
            f"study: after {seconds:.2f} s", "SIGKILL", len(before), len(after), -9, wrong
        )

    def seconds_of_study(self) -> float:
        """Return how long the undisturbed study takes."""
        folder, begin = self._folder("timed"), time.monotonic()
        self._run("study", folder, None)
        return time.monotonic() - begin

    def _folder(self, name: str) -> Path:
        folder = self._place / name / "w"
        folder.mkdir(parents=True)
        shutil.copy(self._bench.specimen, folder / "s.toml")
        (folder / "study.toml").write_text(STUDY_FILE, encoding="utf-8")
        return folder

    def _started(self, run: str, folder: Path, place: str | None, *more: str) -> subprocess.Popen:
        words = [*RUNS[run], *more]
        command = [sys.executable, "-P", "-m"]
        command += ["bilayer", *words] if place is None else ["attack.placed", place, *words]
        if run == "FE on 2 ranks":
            command = ["mpirun", "--oversubscribe", "-n", "2", *command]
        clean = {k: v for k, v in os.environ.items() if not k.startswith(WITHOUT_LAUNCHER)}
        clean["PYTHONPATH"] = f"{TESTS}:{TESTS.parent}"
        return subprocess.Popen(
            command,
            cwd=folder,
            env=clean,
            text=True,
            start_new_session=True,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=_hear_ctrl_c,
        )

    def _run(self, run: str, folder: Path, place: str | None, *more: str) -> tuple[int, str]:
        running = self._started(run, folder, place, *more)
        try:
            _, said = running.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(running.pid, signal.SIGKILL)
            return -99, running.communicate()[1]
        return running.returncode, said

    def _ending(self, moment: Moment, number: signal.Signals, status: int, said: str) -> str:
        """Return what is wrong with the exit status and the words of a run."""
        if status == -99:
            return "hangs"
        if number == signal.SIGKILL:
            return ""
        if "Traceback" in said:
            return f"traceback: {said.strip().splitlines()[-1][:100]}"
        if moment.run == "FE on 2 ranks":  # mpirun speaks, and has a status of its own
            return "" if status != 0 else "exit status 0"
        if status != STATUS[number]:
            return f"exit status {status}, not {STATUS[number]}: {said.strip()[-200:]}"
        lines = said.strip().splitlines()
        if len(lines) != 1 or not lines[0].startswith("bilayer: interrupted"):
            return f"{len(lines)} lines: {said.strip()[-300:]}"
        return ""

    def _kept(self, run: str, folder: Path) -> int:
        """Return the number of milestones in the file."""
        from bilayer import open_result

        file = folder / "a.nc"
        if "study" in run:
            found = sorted((folder / "st" / "cases").glob("*.nc"))
            return sum(int(open_result(path)["converged"].sum()) for path in found)
        return int(open_result(file)["converged"].sum()) if file.exists() else 0

    def _goes_on(self, run: str, folder: Path) -> str:
        """Start again; return what is wrong with what is there then."""
        more = () if "study" in run else ("--resume",)
        if run == "task of a study":
            run = "study"
        status, said = self._run(run, folder, None, *more)
        if status != 0:
            return f"the next start ends with {status}: {said.strip()[-200:]}"
        return self._left_behind(folder) or self._compared(run, folder)

    def _left_behind(self, folder: Path) -> str:
        known = {"s.toml", "study.toml", "a.nc", "st"}
        left = [path.name for path in folder.iterdir() if path.name not in known]
        if (folder / "st").exists():
            usual = {"cases", "plan.json", "study.csv", "study.log", ".lock", ".workers"}
            left += [path.name for path in (folder / "st").iterdir() if path.name not in usual]
            cases = (folder / "st" / "cases").iterdir()
            left += [path.name for path in cases if path.suffix != ".nc" or "unfin" in path.name]
        return f"left behind: {', '.join(left)}" if left else ""

    def _compared(self, run: str, folder: Path) -> str:
        """Return how the results differ from the undisturbed ones."""
        from bilayer import open_result

        if run not in self._undisturbed:
            alone = self._folder(f"undisturbed {run}")
            self._run(run, alone, None)
            self._undisturbed[run] = alone
        alone = self._undisturbed[run]
        names = sorted(p.relative_to(alone) for p in alone.rglob("*.nc"))
        found = sorted(p.relative_to(folder) for p in folder.rglob("*.nc"))
        if names != found:
            return f"{len(found)} results instead of {len(names)}"
        for name in names:
            right, there = (open_result(place / name) for place in (alone, folder))
            if not np.allclose(there["position"], right["position"], rtol=0, atol=1e-11):
                return f"{name}: other shapes"
        return ""

    def _finished(self, folder: Path) -> dict[str, float]:
        cases = (folder / "st" / "cases").glob("*.nc")
        return {p.name: p.stat().st_mtime for p in cases if "unfinished" not in p.name}


def _hear_ctrl_c() -> None:
    """Take Ctrl-C as in the foreground: a shell lets what it starts in the background ignore it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def strike_all(bench: Bench, place: Path, only: str = "") -> Iterator[Report]:
    """Yield what came of Ctrl-C and SIGTERM at each moment whose name contains a text."""
    runs = Runs(bench, place)
    for moment in (m for m in MOMENTS if only in f"{m.run}: {m.what}"):
        for number in (signal.SIGINT, signal.SIGTERM):
            yield runs.strike(moment, number)


def kill_all(bench: Bench, place: Path, seed: int, count: int = 20) -> Iterator[Report]:
    """Yield what came of SIGKILL at the placed moments, and at random ones of a study."""
    runs = Runs(bench, place)
    for moment in KILLS:
        yield runs.strike(replace(moment), signal.SIGKILL)
    whole, chance = runs.seconds_of_study(), random.Random(seed)
    for _ in range(count):
        yield runs.kill_at_random(chance.uniform(0.05, 1.0) * whole)
