"""The computations that two revisions are compared by, and what is counted of each.

Only names of `bilayer.__all__`, variables of a result and the command line are used, so that an
earlier revision runs the same. PETSc's own log counts the factorisations of both solvers.
"""

import resource
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import bilayer

FACTORISATIONS = ("MatCholFctrNum", "MatLUFactorNum")
"""PETSc's events of a numeric factorisation."""
COARSE = 10e-3  # m, of the release that loads the libraries and compiles the forms
STUDY = """\
specimen = "specimen.toml"
solver = "dshell"
[vary]
"cut.cutout_angle" = { start = 0.3, stop = 0.4, num = 6 }
"kirigami.thickness" = { start = 0.0008, stop = 0.0012, num = 10 }
"prestretch.milestones" = [1.06, 1.15]
"""


@dataclass(frozen=True)
class Cost:
    """The cost of one computation, and numbers of its result.

    Parameters
    ----------
    cpu : float
        Seconds, of all its processes.
    gigabytes : float
        Peak memory of its largest process.
    iterations, factorisations : int or None
        Newton iterations, and numeric factorisations of sparse matrices; None if nobody counts.
    numbers : sequence of float
        Of the result, to be compared between revisions.
    """

    cpu: float
    gigabytes: float
    iterations: int | None = None
    factorisations: int | None = None
    numbers: Sequence[float] = ()


@dataclass(frozen=True)
class ComparedCase:
    """A computation by name.

    Parameters
    ----------
    text : str
        What it is, in a line.
    run : callable
        Does it in an empty folder and returns its cost.
    rehearse : callable
        Does something small in the same folder before, which loads and compiles the same.
    """

    text: str
    run: Callable[[Path], Cost]
    rehearse: Callable[[Path], Any]


def _specimen(size: float, *milestones: float) -> bilayer.Specimen:
    whole = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(size))
    return whole.with_milestones(list(milestones)) if milestones else whole


def _solved(
    text: str, solver: str, size: float, *milestones: float, settings: Any = None
) -> ComparedCase:
    """A release in this process; the planar mesh is not counted."""

    def run(folder: Path) -> Cost:
        specimen = _specimen(size, *milestones)
        mesh = bilayer.generate_mesh(specimen)
        before = _factorisations()
        begin = time.process_time()
        result = bilayer.solve(specimen, solver, settings, mesh=mesh)
        cpu = time.process_time() - begin
        count = None if before is None else (_factorisations() or 0) - before
        iterations = int(result["iterations"].sum())
        return Cost(cpu, _gigabytes("SELF"), iterations, count, _numbers(result))

    return ComparedCase(
        text, run, lambda folder: bilayer.solve(_specimen(COARSE, 1.01), solver, settings)
    )


def _command(text: str, *words: str, prepare: Callable[[Path], Any] | None = None) -> ComparedCase:
    """A process of its own, from its start to its end; `out.nc` is read if it is there."""

    def rehearse(folder: Path) -> None:
        if prepare is not None:
            prepare(folder)
        _run(folder, *words)

    def run(folder: Path) -> Cost:
        cpu = _run(folder, *words)
        memory = _gigabytes("CHILDREN")
        if not (folder / "out.nc").exists():
            return Cost(cpu, memory)
        result = bilayer.open_result(folder / "out.nc")
        count = int(result["factorisations"].sum()) if "factorisations" in result else None
        return Cost(cpu, memory, int(result["iterations"].sum()), count, _numbers(result))

    return ComparedCase(text, run, rehearse)


def _study() -> ComparedCase:
    """Sixty shells on two ranks."""

    def prepare(folder: Path) -> None:
        _write_specimen(folder)
        (folder / "study.toml").write_text(STUDY, encoding="utf-8")
        _run(folder, "study", "study.toml", "-o", "nothing", "--dry-run")

    def run(folder: Path) -> Cost:
        words = ["study", "study.toml", "-o", "study", "--quiet"]
        cpu = _run(folder, *words, launcher=("mpirun", "-n", "2"))
        memory = _gigabytes("CHILDREN")
        files = (folder / "study" / "cases").glob("*.nc")
        results = sorted(map(bilayer.open_result, files), key=_varied)
        counts, numbers = zip(
            *((int(one["iterations"].sum()), _numbers(one)) for one in results), strict=True
        )
        return Cost(cpu, memory, sum(counts), None, [x for one in numbers for x in one])

    return ComparedCase("study of 60 shells, 4 mm, on two ranks", run, prepare)


def _varied(result: xr.Dataset) -> tuple[float, float]:
    """Return what the study varies; the files' names change with the settings that there are."""
    kirigami = bilayer.result_specimen(result).layer("kirigami")
    assert isinstance(kirigami.pattern, bilayer.CutPattern)
    return kirigami.pattern.cutout_angle, kirigami.thickness


def _write_specimen(folder: Path) -> None:
    text = bilayer.specimen_to_toml(_specimen(4e-3))
    (folder / "specimen.toml").write_text(text, encoding="utf-8")


def _write_result(folder: Path) -> None:
    result = bilayer.solve(_specimen(COARSE, 1.03, 1.06), "dshell")
    bilayer.write_result(result, folder / "in.nc")


def _run(folder: Path, *words: str, launcher: Sequence[str] = ()) -> float:
    """Run `bilayer` (or Python, if the first word is "-c") and return the CPU seconds."""
    python = [*launcher, sys.executable]
    command = [*python, *words] if words[0] == "-c" else [*python, "-m", "bilayer", *words]
    before = _child_seconds()
    subprocess.run(command, cwd=folder, check=True, stdout=subprocess.DEVNULL)
    return _child_seconds() - before


def _child_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _gigabytes(whose: str) -> float:
    return resource.getrusage(getattr(resource, f"RUSAGE_{whose}")).ru_maxrss * 1024 / 1e9


def _factorisations() -> int | None:
    """Return the number of factorisations in this process so far; None without PETSc."""
    try:
        from petsc4py import PETSc
    except ImportError:
        return None
    PETSc.Log.begin()
    events = (PETSc.Log.Event(name) for name in FACTORISATIONS)
    return sum(event.getPerfInfo()["count"] for event in events)


def _numbers(result: xr.Dataset) -> list[float]:
    """Return the shape's measures and its energies at every milestone."""
    names = ("sphere_radius", "sphere_rmse", "height", "hemisphere_distance", "energy")
    return [float(x) for name in names if name in result for x in np.ravel(result[name].values)]


def _from_flat() -> Any:
    return bilayer.MorleySettings(coarse_triangles=0)


CASES = {
    "shell": _solved(
        "shell, 1.3k triangles, 1.15 from flat", "dshell", 3.2734e-3, 1.15, settings=_from_flat()
    ),
    "shell-sweep": _solved("shell, default mesh, eight prestretches", "dshell", 3e-3),
    "shell-fine": _solved(
        "shell, 17.6k triangles, 1.15, default start", "dshell", 0.83457e-3, 1.15
    ),
    "shell-finest": _solved(
        "shell, 86k triangles, 1.15, default start", "dshell", 0.37323e-3, 1.15
    ),
    "fenics-sweep": _solved("FE, default mesh, eight prestretches", "fenics", 3e-3),
    "fenics-fine": _solved("FE, 7.5k triangles, 1.06", "fenics", 1.31e-3, 1.06),
    "fenics-coarse": _command(
        "FE, 6 mm, 1.06, whole process",
        *("solve", "specimen.toml", "--solver", "fenics", "--mesh-size", "0.006"),
        *("--prestretch", "1.06", "-o", "out.nc", "--quiet"),
        prepare=_write_specimen,
    ),
    "study": _study(),
    "import": _command("import bilayer", "-c", "import bilayer"),
    "names": _command(
        "import every public name",
        "-c",
        "import bilayer; [getattr(bilayer, n) for n in bilayer.__all__]",
    ),
    "help": _command("bilayer --help", "--help"),
    "info": _command("bilayer info", "info", "in.nc", prepare=_write_result),
}
