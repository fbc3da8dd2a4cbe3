"""The opening of a shell's load path, flat or at a start, from a specimen and settings."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import xarray as xr

from bilayer.contact.package import contact_is_installed
from bilayer.contact.specimen_obstacles import check_obstacles_are_seen
from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import result_mesh
from bilayer.results.starting import (
    FLAT_START,
    Neighbour,
    describe_run,
    describe_start,
    starting_shape,
)
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Solver, SpecimenPath, Start
from bilayer.solvers.recording import leave_unmeasured
from bilayer.solvers.run import solve_with
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair, stretch_of
from bilayer.specimen.specimen import Specimen, refuse_time
from dshell.models.hinge import HingeModel
from dshell.models.morley import MorleyModel
from dshell.release.branches import BRANCH_RULES
from dshell.release.coarse_start import Array, coarse_mesh, prolong_shape
from dshell.release.dynamic import DynamicPath, MotionLimits
from dshell.release.paper import PaperPath
from dshell.release.specimen_path import Begin, Beginning, ShellPath
from dshell.release.specimen_shell import ContactLimits, ShellModel, SpecimenShell
from dshell.release.states import ShellStateFinder
from dshell.release.static import StaticPath, StepLimits, equilibrium_solver
from dshell.settings import MorleySettings, PaperSettings, ReleaseSettings
from dshell.solve.linear_solver import best_linear_solver
from dshell.solve.newton import EquilibriumSolver

MakeModel = Callable[[Specimen, PlanarMesh], ShellModel]
Prolong = Callable[[Array, PlanarMesh, PlanarMesh], Array]
"""Takes a shape on a coarse mesh, that mesh and a fine one; returns the shape on the fine one."""


@dataclass(frozen=True)
class CoarseStart:
    """The start of a fine mesh from the shape on a coarse one.

    Parameters
    ----------
    solver : Solver
        Finds the shape on the coarse mesh.
    progress : callable, optional
        Told of a coarse mesh that comes first.
    prolong : callable
        Takes the shape to the fine mesh.
    """

    solver: Solver
    progress: Progress | None = None
    prolong: Prolong = prolong_shape

    def beginning(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        settings: ReleaseSettings,
        target: Milestone,
    ) -> Beginning:
        """Return the shape on a coarse mesh, or none, that leads to the first target."""
        coarse = self._result(specimen.at_milestone(target), mesh, settings)
        if coarse is None:
            return Beginning(None, FLAT_START)
        if not coarse["converged"].all():
            return Beginning(
                None, f"{FLAT_START}, because on a coarse mesh it {coarse.attrs['stop_reason']}"
            )
        shape = self.prolong(coarse["position"].values[0], result_mesh(coarse), mesh)
        return Beginning(shape, f"{FLAT_START}, on a coarse mesh first: {describe_run(coarse)}")

    def _result(
        self, specimen: Specimen, mesh: PlanarMesh, settings: ReleaseSettings
    ) -> xr.Dataset | None:
        """Return the result on a coarse mesh if the mesh is fine and the settings ask for it."""
        if settings.method != "static":
            return None
        coarse = coarse_mesh(specimen, mesh, settings.coarse_triangles)
        if coarse is None:
            return None
        if self.progress is not None:
            self.progress(0.0, f"a coarse mesh of {len(coarse.triangles)} triangles first")
        return solve_with(
            self.solver, specimen, settings, mesh=coarse, measure_shape=leave_unmeasured
        )


def open_shell_path(
    specimen: Specimen,
    settings: ReleaseSettings | PaperSettings,
    mesh: PlanarMesh,
    start: Start,
    coarse: CoarseStart,
) -> SpecimenPath:
    """Return the load path of a specimen's shell; see `dshell.solver.open_path`.

    Parameters
    ----------
    specimen, settings, mesh, start
        As for `dshell.solver.open_path`.
    coarse : CoarseStart
        Finds the shape on a coarse mesh, if there is no other start.
    """
    if isinstance(settings, PaperSettings):
        if start is not None:
            raise InputError(
                "start = a result: the paper's model runs each milestone from flat, expected none"
            )
        return PaperPath(specimen, mesh, settings)
    if not isinstance(settings, MorleySettings) or settings.method != "static":
        refuse_time(specimen, "any but the static path of the model 'morley'")
    if isinstance(start, Neighbour):
        return _shell_path(specimen, mesh, settings, _led_all_the_way(start.result, mesh))
    made = start(mesh) if callable(start) else start
    if made is None:
        begin = partial(coarse.beginning, specimen, mesh, settings)
    else:
        starting_shape(made, mesh, UNSTRETCHED)  # raises now if it does not fit
        begin = partial(_led_by, made, mesh)
    return _shell_path(specimen, mesh, settings, [begin])


def _shell_path(
    specimen: Specimen, mesh: PlanarMesh, settings: ReleaseSettings, begins: Sequence[Begin]
) -> ShellPath:
    shell, solver = _shell_and_solver(specimen, mesh, settings)
    return ShellPath(shell, solver, _static_or_dynamic(shell, solver, settings), begins)


def open_shell_finder(
    specimen: Specimen, settings: ReleaseSettings, mesh: PlanarMesh, stretch: StretchPair
) -> ShellStateFinder:
    """Return a finder of a shell's stable shapes; see `bilayer.solvers.contract.OpenFinder`.

    Parameters
    ----------
    specimen, settings, mesh, stretch
        As for `dshell.solver.open_finder`.
    """
    shell, solver = _shell_and_solver(specimen, mesh, settings)
    path = _static_or_dynamic(shell, solver, replace(settings, method="static"))
    return ShellStateFinder(shell, solver, path, stretch)


def _shell_and_solver(
    specimen: Specimen, mesh: PlanarMesh, settings: ReleaseSettings
) -> tuple[SpecimenShell, EquilibriumSolver]:
    check_obstacles_are_seen(specimen, settings.contact)
    models_contact = settings.contact == "barrier" and contact_is_installed()
    contact = ContactLimits(settings.contact_range) if models_contact else None
    make_model = _model_maker(settings)
    shell = SpecimenShell(specimen, mesh, make_model, settings.tolerance, contact)
    return shell, equilibrium_solver(shell, best_linear_solver())


def _static_or_dynamic(
    shell: SpecimenShell, solver: EquilibriumSolver, settings: ReleaseSettings
) -> StaticPath[Milestone]:
    branch = BRANCH_RULES[settings.branch](solver, shell.escape)
    limits = StepLimits(
        settings.tolerance,
        settings.max_iterations,
        settings.longest_step * shell.specimen.characteristic_length,
        settings.ramp,
        settings.smallest_step,
    )
    if settings.method == "dynamic":
        motion = MotionLimits(settings.total_time, settings.time_step, settings.damping_rate)
        return DynamicPath(shell, motion, limits, solver, branch)
    return StaticPath(shell, limits, solver, branch)


def _model_maker(settings: ReleaseSettings) -> MakeModel:
    """Return a function that makes the model of a specimen on a mesh."""
    if isinstance(settings, MorleySettings):
        return partial(MorleyModel, settings=settings)
    return HingeModel


def _led_by(start: xr.Dataset, mesh: PlanarMesh, target: Milestone) -> Beginning:
    """Return the shape of another result that leads to the first target."""
    return Beginning(starting_shape(start, mesh, stretch_of(target)), describe_start(start))


def _led_all_the_way(neighbour: xr.Dataset, mesh: PlanarMesh) -> list[Begin]:
    """Return the shapes of a neighbour, each of which leads to the milestone of its place."""
    starting_shape(neighbour, mesh, UNSTRETCHED)  # raises now if it does not fit
    text = describe_start(neighbour)
    return [partial(_led_to, shape, text) for shape in neighbour["position"].values]


def _led_to(shape: Array, text: str, target: Milestone) -> Beginning:
    return Beginning(shape, text)
