"""A run: a solver's path through the milestones of a specimen, and the dataset that comes of it."""

import math
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import xarray as xr

from bilayer.errors import InputError, Interrupted, NotResumableError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.assembly import Provenance
from bilayer.results.files import check_result_output, open_result, write_result
from bilayer.results.table import place_words
from bilayer.runtime.progress import Progress, never_back
from bilayer.runtime.ranks import is_first_rank
from bilayer.runtime.termination import signals_put_off
from bilayer.solvers.contract import Equilibrium, Solver, SpecimenPath, Start
from bilayer.solvers.path import LoadStep, Observer, follow_path, run_path
from bilayer.solvers.recording import MeasureShape, Recorder
from bilayer.solvers.resuming import Unfinished, check_same_run, open_unfinished
from bilayer.specimen.specimen import Specimen


def solve_with(
    solver: Solver,
    specimen: Specimen,
    settings: Any,
    *,
    mesh: PlanarMesh | None = None,
    start: Start = None,
    comm: Any = None,
    progress: Progress | None = None,
    observers: Sequence[Observer] = (),
    output: str | Path | None = None,
    resume: str | Path | None = None,
    limit: float | None = None,
    measure_shape: MeasureShape | None = None,
) -> xr.Dataset:
    """Compute the shapes of a specimen at its milestones; see `bilayer.solve`.

    Parameters
    ----------
    solver : Solver
        Which one.
    specimen, settings, mesh, comm, progress, observers, output, resume, limit
        See `bilayer.solve`.
    start : Dataset, callable or None
        See `bilayer.solvers.contract.Start`.
    measure_shape : callable, optional
        See `Recorder`.
    """
    model = model_of(solver, settings)
    if output is not None:
        check_result_output(output)
    earlier = None
    if resume is not None:
        with _resuming(resume):
            earlier = open_unfinished(resume)
            held = open_result(resume) if earlier is None else earlier.result
            check_same_run(held, resume, specimen, solver.name, model, settings, mesh)
        if earlier is None:
            if output is not None and Path(output) != Path(resume) and is_first_rank():
                write_result(held, output)
            return held
        if earlier.point.tried == 0:  # there was no time for any
            earlier = None
    progress = None if progress is None else never_back(progress)
    path = _opened(solver, specimen, settings, mesh, start, comm, progress, earlier)
    with closing(path):
        if earlier is not None:
            with _resuming(resume):
                path.restore(earlier.point.saved)
        provenance = Provenance.found(solver.name, model, settings, path.versions)
        recorder = Recorder(specimen, path, provenance, output, earlier, measure_shape)
        telling = []
        if progress is not None and _is_first(path):
            telling = [reporter(progress, specimen)]
        targets = specimen.milestones
        try:
            run_path(
                path,
                targets,
                [recorder, *telling, *observers],
                first=recorder.tried,
                limit=math.inf if limit is None else limit,
            )
            with signals_put_off():
                result: xr.Dataset = _on_every_rank(path, recorder)
            return result
        except KeyboardInterrupt as interrupt:
            if _has_others(path):  # the ranks stop at different places
                raise
            if recorder.tried == 0:  # an `Interrupted` here is of a run that this one starts from
                raise KeyboardInterrupt from interrupt
            with signals_put_off():
                kept = Interrupted(recorder.result(), output)
            raise kept from interrupt


def follow_with(
    solver: Solver,
    specimen: Specimen,
    settings: Any,
    *,
    mesh: PlanarMesh | None = None,
    start: Start = None,
    comm: Any = None,
    observers: Sequence[Observer] = (),
) -> Iterator[Equilibrium]:
    """Yield the equilibria of a specimen on its load path, each live; see `bilayer.follow`."""
    model_of(solver, settings)
    path = _opened(solver, specimen, settings, mesh, start, comm, None, None)
    with closing(path):
        for step in follow_path(path, specimen.milestones, observers):
            if step.failure is not None:
                raise step.failure
            yield step.point


def model_of(solver: Solver, settings: Any) -> str:
    """Return the name of the model whose settings these are; InputError if there is none."""
    for model, kind in solver.models.items():
        if type(settings) is kind:
            return model
    kinds = ", ".join(kind.__name__ for kind in solver.models.values())
    raise InputError(f"settings = {settings!r}: expected one of {kinds}")


def reporter(progress: Progress, specimen: Specimen) -> Observer:
    """Return an observer that tells a progress callback where the path is."""

    def report(step: LoadStep[Any, Any]) -> None:
        progress(step.fraction, place_words(specimen, step.point.milestone))

    return report


def _opened(
    solver: Solver,
    specimen: Specimen,
    settings: Any,
    mesh: PlanarMesh | None,
    start: Start,
    comm: Any,
    progress: Progress | None,
    earlier: Unfinished | None,
) -> SpecimenPath:
    """Return the path of a run, at its beginning; on the mesh of an earlier run if there is one."""
    if earlier is not None:
        mesh, start = earlier.mesh, None
    return solver.open_path(
        specimen, settings, mesh=mesh, start=start, comm=comm, progress=progress
    )


@contextmanager
def _resuming(path: str | Path | None) -> Iterator[None]:
    """Say of an error that the run of a file cannot be resumed.

    A solver takes the arrays of its resume point as they are: one that is missing, of another
    shape or kind ends in an error of Python's own.
    """
    try:
        yield
    except InputError as error:
        raise NotResumableError(str(error)) from error
    except (LookupError, ValueError, TypeError) as error:
        found = " ".join(f"{type(error).__name__}: {error}".split())
        raise NotResumableError(
            f"result file {path}: its resume point is none of this solver's ({found})"
        ) from error


def _on_every_rank(path: SpecimenPath, recorder: Recorder) -> Any:
    """Return the result of a run, put together on the first rank."""
    result = recorder.result() if _is_first(path) else None
    return result if path.comm is None else path.comm.bcast(result)


def _is_first(path: SpecimenPath) -> bool:
    return path.comm is None or path.comm.Get_rank() == 0


def _has_others(path: SpecimenPath) -> bool:
    return path.comm is not None and path.comm.Get_size() > 1
