"""The discrete shell from a specimen to a result."""

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import INTERRUPTED, InputError, Interrupted
from bilayer.mesh.generation import mesh_within_memory
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.result import build_result, result_mesh, starting_shape
from bilayer.results.starting import FLAT, began, described
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from dshell.models.hinge import HingeModel
from dshell.models.morley import MorleyModel
from dshell.release.coarse_start import coarse_mesh, prolonged
from dshell.release.dynamic import DynamicRelease
from dshell.release.paper import release_paper
from dshell.release.static import ShellModel, StaticRelease, visit_milestones
from dshell.release.visit import Visit
from dshell.settings import HingeSettings, MorleySettings, PaperSettings, ReleaseSettings
from dshell.solve.linear_solver import best_linear_solver

Array = NDArray[np.float64]

PARALLEL = False
"""Under mpirun the first rank computes alone."""

BYTES_PER_TRIANGLE = 50_000
"""Memory that a run takes: `scripts/benchmark dshell --largest 100000` measures it."""

DEFAULT_START = "flat"
"""One of `bilayer.solvers.registry.STARTS`."""

MODELS = {"morley": MorleySettings, "hinge": HingeSettings, "paper": PaperSettings}

Settings = MorleySettings | HingeSettings | PaperSettings
Release = Callable[
    [Specimen, PlanarMesh, Any, Array | None, Progress | None],
    Visit,
]


METHODS = {"static": StaticRelease, "dynamic": DynamicRelease}
"""What takes a shell from milestone to milestone, by `settings.method`."""


def _release(
    specimen: Specimen,
    mesh: PlanarMesh,
    model: ShellModel,
    settings: ReleaseSettings,
    start: Array | None,
    progress: Progress | None,
) -> Visit:
    path = METHODS[settings.method](specimen, mesh, model, settings, best_linear_solver())
    return visit_milestones(specimen, path, start, progress)


def _release_morley(
    specimen: Specimen,
    mesh: PlanarMesh,
    settings: MorleySettings,
    start: Array | None,
    progress: Progress | None,
) -> Visit:
    model = MorleyModel(specimen, mesh, settings)
    return _release(specimen, mesh, model, settings, start, progress)


def _release_hinge(
    specimen: Specimen,
    mesh: PlanarMesh,
    settings: HingeSettings,
    start: Array | None,
    progress: Progress | None,
) -> Visit:
    model = HingeModel(specimen, mesh)
    return _release(specimen, mesh, model, settings, start, progress)


_RELEASES: dict[str, Release] = {
    "morley": _release_morley,
    "hinge": _release_hinge,
    "paper": release_paper,
}


def solve(
    specimen: Specimen,
    settings: Settings | None = None,
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
        What to release. Its weight, if any, is a dead load along -z that the centre carries, see
        `bilayer.specimen.support`; the paper's model has none.
    settings : MorleySettings, HingeSettings or PaperSettings, optional
        Their type chooses the model; the default model's defaults where left out.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen where left out.
    start : Dataset, optional
        A result on the same planar mesh, from any solver: its shape nearest to the first milestone
        starts the first milestone. The paper's model has no use for it.
    comm : mpi4py.MPI.Comm, optional
        Not used: each rank that calls computes the whole result.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        See `bilayer.results.result`. A milestone that was not reached has its last shape in
        `last_position`; `stop_reason` says where it stopped and why.

    Raises
    ------
    InputError
        The settings are of no model, the start is on another mesh, the paper's model is given a
        start, a true weight or layers that it has not, or the mesh would not fit into memory.
    """
    chosen = MorleySettings() if settings is None else settings
    model = _model_of(chosen)
    mesh = mesh_within_memory(specimen, mesh, BYTES_PER_TRIANGLE, "the discrete shell")
    shape, beginning = _beginning(specimen, mesh, chosen, start, progress)
    visit = _RELEASES[model](specimen, mesh, chosen, shape, progress)
    result = build_result(
        specimen,
        mesh,
        visit.states,
        solver="dshell",
        model=model,
        settings=chosen,
        versions={"scipy": scipy.__version__},
        stop_reason=visit.stop_reason,
    )
    lost = f"{FLAT}, because what was to start it led nowhere: {beginning}"
    result.attrs["start"] = lost if visit.lost_start else beginning
    if visit.stop_reason == INTERRUPTED:
        raise Interrupted(result)
    return result


def _beginning(
    specimen: Specimen,
    mesh: PlanarMesh,
    settings: Settings,
    start: xr.Dataset | None,
    progress: Progress | None,
) -> tuple[Array | None, str]:
    """Return the shape that the first milestone starts from, None for flat, and what it is."""
    first = specimen.prestretch.milestones[0]
    if start is not None:
        return starting_shape(start, mesh, max(first)), began(start)
    coarse = _coarse_result(specimen.with_milestones([first]), mesh, settings, progress)
    if coarse is None:
        return None, FLAT
    if not coarse["converged"].all():
        return None, f"{FLAT}, because on a coarse mesh it {coarse.attrs['stop_reason']}"
    shape = prolonged(coarse["position"].values[0], result_mesh(coarse), mesh)
    return shape, f"{FLAT}, on a coarse mesh first: {described(coarse)}"


def _coarse_result(
    specimen: Specimen, mesh: PlanarMesh, settings: Settings, progress: Progress | None
) -> xr.Dataset | None:
    """Return the result on a coarse mesh where the mesh is fine and the settings ask for it."""
    if not isinstance(settings, ReleaseSettings) or settings.method != "static":
        return None
    coarse = coarse_mesh(specimen, mesh, settings.coarse_triangles)
    if coarse is None:
        return None
    if progress is not None:
        progress(0.0, f"a coarse mesh of {len(coarse.triangles)} triangles first")
    return solve(specimen, settings, mesh=coarse)


def _model_of(settings: Any) -> str:
    for model, kind in MODELS.items():
        if type(settings) is kind:
            return model
    kinds = ", ".join(kind.__name__ for kind in MODELS.values())
    raise InputError(f"settings = {settings!r}: expected one of {kinds}")
