"""The solvers by name, loaded when asked for, so that reading results needs neither of them.

A solver is a package with

- `MODELS`: its models by name, each the dataclass of that model's settings; the first is the
  default (its class attribute `stopping_is_a_result` says whether a run that stops early succeeds);
- `PARALLEL`: whether the ranks of `mpirun` share one case;
- `BYTES_PER_TRIANGLE`: memory that it takes, for the check before a run;
- `solve(specimen, settings, *, mesh=None, start=None, comm=None, progress=None)`, which returns
  the dataset of `bilayer.result`.
"""

from collections.abc import Callable
from importlib import import_module
from types import ModuleType
from typing import Any

import xarray as xr

from bilayer.planar_mesh import PlanarMesh
from bilayer.specimen import Specimen
from bilayer.validation import one_of

SOLVERS = {"fenics": "fenics_model", "dshell": "dshell"}

Progress = Callable[[float, str], None]
"""Called with the fraction done, from 0 to 1, and a few words on the state of the run."""


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
    start: xr.Dataset | None = None,
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
    start : Dataset, optional
        A result on the same mesh, from either solver, whose shape starts the first milestone.
    comm : mpi4py.MPI.Comm, optional
        The communicator; COMM_WORLD where a solver is parallel and none is given.
    progress : callable, optional
        See `Progress`.

    Returns
    -------
    Dataset
        See `bilayer.result`.
    """
    package = solver_package(solver)
    chosen = settings_kind(solver)() if settings is None else settings
    return package.solve(specimen, chosen, mesh=mesh, start=start, comm=comm, progress=progress)
