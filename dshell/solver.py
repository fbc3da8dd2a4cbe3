"""The discrete shell as a solver: from a specimen to its load path."""

from collections.abc import Callable
from functools import partial
from typing import Any

import xarray as xr

from bilayer.errors import InputError
from bilayer.mesh.generation import mesh_within_memory
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import result_mesh
from bilayer.results.starting import FLAT_START, describe_run, describe_start, starting_shape
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Solver, SpecimenPath, Start
from bilayer.solvers.run import solve_with
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair
from bilayer.specimen.specimen import Specimen
from dshell.models.hinge import HingeModel
from dshell.models.morley import MorleyModel
from dshell.release.branches import BRANCH_RULES
from dshell.release.coarse_start import coarse_mesh, prolong_shape
from dshell.release.dynamic import DynamicPath, MotionLimits
from dshell.release.paper import PaperPath
from dshell.release.specimen_path import Begin, Beginning, ShellPath
from dshell.release.specimen_shell import ShellModel, SpecimenShell
from dshell.release.static import StaticPath, StepLimits, equilibrium_solver
from dshell.settings import HingeSettings, MorleySettings, PaperSettings, ReleaseSettings
from dshell.solve.linear_solver import best_linear_solver

BYTES_PER_TRIANGLE = 50_000
"""Memory that a run takes: `scripts/benchmark dshell --largest 100000` measures it."""

MODELS = {"morley": MorleySettings, "hinge": HingeSettings, "paper": PaperSettings}

MakeModel = Callable[[Specimen], ShellModel]


def open_path(
    specimen: Specimen,
    settings: Any,
    *,
    mesh: PlanarMesh | None = None,
    start: Start = None,
    comm: Any = None,
    progress: Progress | None = None,
) -> SpecimenPath:
    """Return the load path of a specimen; see `bilayer.solvers.contract.OpenPath`.

    Parameters
    ----------
    specimen : Specimen
        What to release. Its weight, if any, is a dead load along -z that the centre carries, see
        `bilayer.specimen.support`; the paper's model has none.
    settings : MorleySettings, HingeSettings or PaperSettings
        Their type chooses the model.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen if left out.
    start : Dataset or callable, optional
        A result on the same planar mesh, from any solver: its shape nearest to the first target
        leads to it. The paper's model has no use for it.
    comm : mpi4py.MPI.Comm, optional
        Not used: each rank that calls computes the whole path.
    progress : callable, optional
        Told of a coarse mesh that comes first.

    Raises
    ------
    InputError
        The settings are of no model, the start is on another mesh, the paper's model is given a
        start, a true weight or layers that it has not, or the mesh would not fit into memory.
    """
    if not any(type(settings) is kind for kind in MODELS.values()):
        kinds = ", ".join(kind.__name__ for kind in MODELS.values())
        raise InputError(f"settings = {settings!r}: expected one of {kinds}")
    mesh = mesh_within_memory(specimen, mesh, BYTES_PER_TRIANGLE, "the discrete shell")
    if isinstance(settings, PaperSettings):
        if start is not None:
            raise InputError(
                "start = a result: the paper's model runs each milestone from flat, expected none"
            )
        return PaperPath(specimen, mesh, settings)
    made = start(mesh) if callable(start) else start
    if made is None:
        begin = partial(_coarse_beginning, specimen, mesh, settings, progress)
    else:
        starting_shape(made, mesh, UNSTRETCHED)  # raises now if it does not fit
        begin = partial(_led_by, made, mesh)
    return _shell_path(specimen, mesh, settings, begin)


SOLVER = Solver(
    name="dshell",
    models=MODELS,
    parallel=False,
    bytes_per_triangle=lambda specimen, settings: BYTES_PER_TRIANGLE,
    default_start="flat",
    open_path=open_path,
)
"""This package, as the registry finds it."""


def _shell_path(
    specimen: Specimen, mesh: PlanarMesh, settings: ReleaseSettings, begin: Begin
) -> ShellPath:
    shell = SpecimenShell(specimen, mesh, _model_maker(mesh, settings), settings.tolerance)
    solver = equilibrium_solver(shell, best_linear_solver())
    branch = BRANCH_RULES[settings.branch](solver, shell.escape)
    limits = StepLimits(
        settings.tolerance,
        settings.max_iterations,
        settings.longest_step * specimen.characteristic_length,
        settings.ramp,
        settings.smallest_step,
    )
    path: StaticPath[StretchPair]
    if settings.method == "dynamic":
        motion = MotionLimits(settings.total_time, settings.time_step, settings.damping_rate)
        path = DynamicPath(shell, motion, limits, solver, branch)
    else:
        path = StaticPath(shell, limits, solver, branch)
    return ShellPath(shell, solver, path, begin)


def _model_maker(mesh: PlanarMesh, settings: ReleaseSettings) -> MakeModel:
    """Return a function that makes the model of a specimen."""
    if isinstance(settings, MorleySettings):
        return lambda specimen: MorleyModel(specimen, mesh, settings)
    return partial(HingeModel, mesh=mesh)


def _led_by(start: xr.Dataset, mesh: PlanarMesh, target: StretchPair) -> Beginning:
    """Return the shape of another result that leads to the first target."""
    return Beginning(starting_shape(start, mesh, target), describe_start(start))


def _coarse_beginning(
    specimen: Specimen,
    mesh: PlanarMesh,
    settings: ReleaseSettings,
    progress: Progress | None,
    target: StretchPair,
) -> Beginning:
    """Return the shape on a coarse mesh, or none, that leads to the first target."""
    coarse = _coarse_result(specimen.with_milestones([target]), mesh, settings, progress)
    if coarse is None:
        return Beginning(None, FLAT_START)
    if not coarse["converged"].all():
        return Beginning(
            None, f"{FLAT_START}, because on a coarse mesh it {coarse.attrs['stop_reason']}"
        )
    shape = prolong_shape(coarse["position"].values[0], result_mesh(coarse), mesh)
    return Beginning(shape, f"{FLAT_START}, on a coarse mesh first: {describe_run(coarse)}")


def _coarse_result(
    specimen: Specimen, mesh: PlanarMesh, settings: ReleaseSettings, progress: Progress | None
) -> xr.Dataset | None:
    """Return the result on a coarse mesh if the mesh is fine and the settings ask for it."""
    if settings.method != "static":
        return None
    coarse = coarse_mesh(specimen, mesh, settings.coarse_triangles)
    if coarse is None:
        return None
    if progress is not None:
        progress(0.0, f"a coarse mesh of {len(coarse.triangles)} triangles first")
    return solve_with(SOLVER, specimen, settings, mesh=coarse)
