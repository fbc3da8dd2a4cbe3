"""The solvers by name, loaded when asked for, so that reading results needs neither of them.

A solver is a package with

- `MODELS`: its models by name, each the dataclass of that model's settings; the first is the
  default (its class attribute `stopping_is_a_result` says whether a run that stops early succeeds);
- `PARALLEL`: whether the ranks of `mpirun` share one case;
- `BYTES_PER_TRIANGLE`: memory that it takes, for the check before a run;
- `DEFAULT_START`: one of `STARTS`, from where its runs start unless told;
- `solve(specimen, settings, *, mesh=None, start=None, comm=None, progress=None)`, which returns
  the dataset of `bilayer.results.result`; `start` is a result, a function that makes one on the
  mesh of the run, or None for the flat state.
"""

from functools import partial
from importlib import import_module
from types import ModuleType
from typing import Any

import xarray as xr

from bilayer.errors import ComputationError, InputError, Interrupted
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.starting import with_waypoints
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from bilayer.validation import one_of

SOLVERS = {"fenics": "fenics_model", "dshell": "dshell"}

STARTS = ("shell", "flat")
"""From where a run starts: the accurate shell's shapes lead the way, or the flat state."""


def solver_package(name: str) -> ModuleType:
    """Return the package of a solver; raise InputError where the name is unknown."""
    return import_module(SOLVERS[one_of("solver", name, SOLVERS)])


def settings_kind(solver: str, model: str | None = None) -> type:
    """Return the settings dataclass of a solver's model; None is the solver's default model."""
    models = solver_package(solver).MODELS
    return models[next(iter(models)) if model is None else one_of("model", model, models)]


def solve(
    specimen: Specimen,
    solver: str = "fenics",
    settings: Any = None,
    *,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | str | None = None,
    comm: Any = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the shapes of a specimen at its milestones.

    Parameters
    ----------
    specimen : Specimen
        What to release.
    solver : {"fenics", "dshell"}
        Which package computes.
    settings : settings dataclass, optional
        One of the solver's `MODELS`; the default model with its defaults where left out.
    mesh : PlanarMesh, optional
        The planar mesh to use; made from the specimen where left out.
    start : {"shell", "flat"} or Dataset, optional
        "shell": the shapes of the accurate discrete shell lead the way. "flat": nothing does, but
        that a fine mesh of the shell goes by a coarse one (its setting `coarse_triangles`). A
        result on the same mesh, from either solver: its shape starts the first milestone, and leads
        to the others that it has. The solver's own default where left out.
    comm : mpi4py.MPI.Comm, optional
        The communicator; COMM_WORLD where a solver is parallel and none is given.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        See `bilayer.results.result`.
    """
    package = solver_package(solver)
    chosen = settings_kind(solver)() if settings is None else settings
    begin = _start_of(specimen, solver, package.DEFAULT_START if start is None else start)
    return package.solve(specimen, chosen, mesh=mesh, start=begin, comm=comm, progress=progress)


def _start_of(specimen: Specimen, solver: str, start: xr.Dataset | str) -> Any:
    """Return what a solver's package takes for a start."""
    if not isinstance(start, str):
        return start
    if one_of("start", start, STARTS) == "flat":
        return None
    if solver == "dshell":
        raise InputError("start = 'shell': expected 'flat' or a result, the shell leads itself")
    return partial(_shell_result, specimen)


def _shell_result(specimen: Specimen, mesh: PlanarMesh) -> xr.Dataset:
    """Return the accurate shell at the milestones and between, as far as it comes.

    Raises
    ------
    ComputationError
        It reaches no milestone.
    """
    try:
        result = solve(with_waypoints(specimen), "dshell", mesh=mesh)
    except Interrupted as interrupted:  # its result is not that of the run
        raise KeyboardInterrupt from interrupted
    if not result["converged"].any():
        raise ComputationError(f"the shell {result.attrs['stop_reason']}")
    return result
