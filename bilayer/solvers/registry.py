"""The solvers by name, loaded when asked for, so that reading results needs neither of them.

A solver is a package with an object `SOLVER`, see `bilayer.solvers.contract`.
"""

from collections.abc import Iterator, Sequence
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.errors import ComputationError, InputError, Interrupted
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.starting import Neighbour, with_waypoints
from bilayer.runtime.progress import Progress, progress_asked
from bilayer.runtime.termination import signals_put_off
from bilayer.solvers.contract import Equilibrium, Solver, Start
from bilayer.solvers.path import Observer
from bilayer.solvers.recording import leave_unmeasured
from bilayer.solvers.run import follow_with, solve_with
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import read_specimen
from bilayer.validation import one_of, positive

SOLVERS = {"fenics": "fenics_model", "dshell": "dshell"}

STARTS = ("shell", "flat")
"""Starts by name: the shapes of the accurate shell as initial guesses, or the flat state."""
SHARED = ("contact", "contact_range")
"""Settings that the shell which leads another solver has from it."""


def solver_named(name: str) -> Solver:
    """Return a solver; raise InputError if the name is unknown."""
    with signals_put_off():  # compiled modules may turn Ctrl-C into another error
        package = import_module(SOLVERS[one_of("solver", name, SOLVERS)])
    solver: Solver = package.SOLVER
    return solver


def settings_class(solver: str, model: str | None = None) -> type:
    """Return the settings dataclass of a solver's model; None is the solver's default model."""
    models = solver_named(solver).models
    return models[next(iter(models)) if model is None else one_of("model", model, models)]


def solve(
    specimen: Specimen | str | Path,
    solver: str = "fenics",
    settings: Any = None,
    *,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | Neighbour | str | None = None,
    comm: Any = None,
    progress: Progress | bool | None = None,
    observers: Sequence[Observer] = (),
    output: str | Path | None = None,
    resume: str | Path | None = None,
    limit: float | None = None,
) -> xr.Dataset:
    """Compute the shapes of a specimen at its milestones.

    Parameters
    ----------
    specimen : Specimen or path-like
        The specimen, or its file.
    solver : {"fenics", "dshell"}
        Which package computes.
    settings : settings dataclass, optional
        One of the solver's models; the default model with its defaults if left out.
    mesh : PlanarMesh, optional
        The planar mesh to use; made from the specimen if left out.
    start : {"shell", "flat"} or Dataset, optional
        Initial guesses. "shell": the shapes of the accurate discrete shell. "flat": none; a fine
        mesh of the shell then starts from a coarse one (its setting `coarse_triangles`). A result
        on the same mesh, from either solver: its shapes. The solver's own default if left out.
    comm : mpi4py.MPI.Comm, optional
        The communicator; COMM_WORLD if a solver is parallel and none is given.
    progress : callable or bool, optional
        True: a bar; False: none; left out: a bar in a notebook. Or a callback, see
        `bilayer.runtime.progress.Progress`.
    observers : sequence of callable
        Each is told of every `bilayer.solvers.path.LoadStep`, on every rank, after the milestone is
        kept.
    output : path-like, optional
        Result file: each milestone is in it when it is reached, whatever happens after.
    resume : path-like, optional
        Result file of a run that was not finished, of the same specimen, settings and milestones:
        go on from its last milestone. A finished one is returned as it is.
    limit : float, optional
        Seconds that a milestone may take. The run ends at one that takes longer, with the
        milestones before it; `resume` goes on from there.

    Returns
    -------
    Dataset
        See `bilayer.results.schema`.

    Raises
    ------
    InputError
        See the message.
    Interrupted
        Ctrl-C; with the milestones that were reached, if there are any.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> 0.01 < float(result["height"].sel(prestretch=1.03)) < 0.02  # m
    True
    """
    asked, chosen = specimen_given(specimen), solver_named(solver)
    with progress_asked(solver, progress) as report:
        return solve_with(
            chosen,
            asked,
            settings_class(solver)() if settings is None else settings,
            mesh=mesh,
            start=_start_of(asked, chosen, start, settings),
            comm=comm,
            progress=report,
            observers=observers,
            output=output,
            resume=resume,
            limit=None if limit is None else positive("limit", limit, unit="s"),
        )


def follow(
    specimen: Specimen | str | Path,
    solver: str = "fenics",
    settings: Any = None,
    *,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | str | None = None,
    comm: Any = None,
    observers: Sequence[Observer] = (),
) -> Iterator[Equilibrium]:
    """Follow a specimen through its milestones, one equilibrium after the other.

    Parameters
    ----------
    specimen, solver, settings, mesh, start, comm, observers
        As for `solve`.

    Yields
    ------
    Equilibrium
        Each one on the way; those at a milestone have `share` = 1. It is live until the next one
        is asked for: see `bilayer.solvers.contract.Equilibrium`.

    Raises
    ------
    ComputationError
        The path ends before the last milestone.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> for equilibrium in bilayer.follow(specimen, "dshell"):
    ...     if equilibrium.share == 1:
    ...         print(equilibrium.stretch, equilibrium.measures().shape.height > 0)
    (1.03, 1.03) True
    """
    asked, chosen = specimen_given(specimen), solver_named(solver)
    return follow_with(
        chosen,
        asked,
        settings_class(solver)() if settings is None else settings,
        mesh=mesh,
        start=_start_of(asked, chosen, start, settings),
        comm=comm,
        observers=observers,
    )


def specimen_given(specimen: Specimen | str | Path) -> Specimen:
    """Return a specimen, read if its file is given.

    Raises
    ------
    InputError
        It is neither, or the file cannot be read.
    """
    if isinstance(specimen, Specimen):
        return specimen
    if isinstance(specimen, (str, Path)):
        return read_specimen(specimen)
    raise InputError(f"specimen = {specimen!r}: expected a Specimen or the path of its file")


def _start_of(
    specimen: Specimen, solver: Solver, start: xr.Dataset | Neighbour | str | None, settings: Any
) -> Start:
    """Return the start in the form that a path takes."""
    chosen = solver.default_start if start is None else start
    if not isinstance(chosen, str):
        return chosen
    if one_of("start", chosen, STARTS) == "flat":
        return None
    if solver.name == "dshell":
        raise InputError("start = 'shell': expected 'flat' or a result, the shell leads itself")
    return partial(_shell_result, specimen, _shell_settings(settings))


def _shell_settings(settings: Any) -> Any:
    """Return the settings of the shell that leads another solver: its own, contact as there."""
    shared = {name: getattr(settings, name) for name in SHARED if hasattr(settings, name)}
    return settings_class("dshell")(**shared)


def _shell_result(specimen: Specimen, settings: Any, mesh: PlanarMesh) -> xr.Dataset:
    """Return the accurate shell at the milestones and between, as far as it comes.

    Raises
    ------
    ComputationError
        It reaches no milestone.
    """
    try:
        result = solve_with(
            solver_named("dshell"),
            with_waypoints(specimen),
            settings,
            mesh=mesh,
            measure_shape=leave_unmeasured,
        )
    except Interrupted as interrupted:  # its result is not that of the run
        raise KeyboardInterrupt from interrupted
    if not result["converged"].any():
        raise ComputationError(f"the shell {result.attrs['stop_reason']}")
    return result
