"""The release of a specimen: from its solid through the milestones to the dataset."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import basix
import dolfinx
import numpy as np
import xarray as xr
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.errors import INTERRUPTED, BilayerError, Interrupted
from bilayer.geometry.alignment import placed
from bilayer.mesh.generation import mesh_within_memory
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.result import UNKNOWN_STABILITY, MilestoneState, build_result
from bilayer.results.starting import ShapeOnTheWay, began, described, shapes_on_the_way
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import support
from fenics_model.branches.branch_search import BranchSearch, Departure, SearchRule
from fenics_model.branches.gradient_flow import FlowRule, GradientFlow
from fenics_model.path.continuation import Continuation, Equilibrium, PathError, Tolerances
from fenics_model.path.guide import Guide
from fenics_model.path.shell_start import Extrusion, settle
from fenics_model.path.step_control import StepControl
from fenics_model.release.branch_fields import branch_dataset
from fenics_model.release.effort_fields import effort_dataset
from fenics_model.release.specimen_solid import (
    BilayerSolid,
    bilayer_solid,
    held_points,
    uneven_lift,
)
from fenics_model.release.volume_fields import volume_dataset
from fenics_model.settings import BYTES_PER_TRIANGLE, MODELS, SolidSettings
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton
from fenics_model.solve.work import Stopwatch, Work

REFERENCE_STRETCH = (1.001, 1.001)
"""Tolerances are relative to what is to be balanced, at least to this prestretch."""

FIRST_DISTANCE = 0.1
"""Of the walk off an unstable milestone, over the substrate's thickness."""


def release(
    specimen: Specimen,
    settings: SolidSettings,
    *,
    mesh: PlanarMesh | None,
    start: xr.Dataset | Callable[[PlanarMesh], xr.Dataset] | None,
    comm: MPI.Comm | None,
    progress: Progress | None,
) -> xr.Dataset:
    """Do what `fenics_model.solve` says."""
    comm = MPI.COMM_WORLD if comm is None else comm
    planar: PlanarMesh = from_first_rank(comm, lambda: _checked_mesh(specimen, mesh, settings))
    body = bilayer_solid(specimen, planar, settings, comm)
    start, start_description = _made_start(start, planar, comm)
    shapes = (
        [] if start is None else shapes_on_the_way(start, planar, specimen.prestretch.milestones)
    )
    run = Release(specimen, planar, body, settings, shapes, progress if comm.rank == 0 else None)
    stop_reason = run.follow()
    states, positions, efforts, works, departures, stop_reason = comm.bcast(
        (run.states, run.positions, run.efforts, run.works, run.departures, stop_reason)
    )
    milestones = len(body.path.milestones)
    result = build_result(
        specimen,
        planar,
        states,
        solver="fenics",
        model=next(iter(MODELS)),
        settings=settings,
        versions=versions(),
        stop_reason=stop_reason,
        extra=volume_dataset(body.solid.mesh.volume, body.layer_names, positions, milestones)
        .merge(effort_dataset(efforts, works, milestones))
        .merge(branch_dataset(departures, milestones)),
    )
    result = result.assign_attrs(start="; ".join([start_description, *run.shapes_left()]))
    if stop_reason == INTERRUPTED:
        raise Interrupted(result)
    return result


class Release:
    """One run: follows the load path of a specimen's solid and keeps what its milestones are.

    Parameters
    ----------
    specimen : Specimen
        Whose milestones.
    mesh : PlanarMesh
        The planar mesh of the solid.
    body : BilayerSolid
        The solid.
    settings : SolidSettings
        Steps and tolerances.
    shapes : sequence of ShapeOnTheWay
        Of another result, that lead the way.
    progress : callable or None
        Told of every load step.

    Attributes
    ----------
    states : list of MilestoneState
        Of the milestones so far.
    positions : list of (v, 3) array of float
        Vertices of the volume mesh at the milestones that were reached, m.
    efforts, works : list of Effort, of Work
        What each of `states` took.
    departures : list of Departure or None
        Of the milestones that were reached: how an unstable equilibrium was left.
    """

    def __init__(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        body: BilayerSolid,
        settings: SolidSettings,
        shapes: Sequence[ShapeOnTheWay],
        progress: Progress | None,
    ) -> None:
        self._nominal = specimen.prestretch.nominal
        self._mesh, self._body = mesh, body
        self._settings, self._progress = settings, progress
        solid = body.solid
        self._comm = solid.mesh.mesh.comm
        self._held = support(mesh.points, specimen.gravity)
        self._absent = solid.absent_pressures()
        self._stopwatch = Stopwatch()
        self._newton = Newton(
            solid,
            [*self._absent, *solid.held_points(held_points(self._held, solid.mesh.volume))],
            iteration_limit=settings.iteration_limit,
            options=settings.petsc_options,
            stopwatch=self._stopwatch,
        )
        radius, substrate = specimen.outer_radius, specimen.substrate
        self._flow = GradientFlow(
            self._newton,
            first_viscosity=substrate.material.shear_modulus * substrate.thickness / radius**3,
            rule=FlowRule(step_limit=settings.flow_steps),
        )
        self._search = BranchSearch(
            self._newton,
            self._flow,
            first_distance=FIRST_DISTANCE * substrate.thickness,
            side=uneven_lift(body, radius),
            rule=SearchRule(choice=settings.branch),
        )
        body.prestretch(REFERENCE_STRETCH)
        self._guide = self._guide_along(shapes)
        self._tolerances = Tolerances(
            settings.tolerance,
            settings.path_tolerance,
            self._newton.residual_norm(solid.undeformed),
        )
        self.states: list[MilestoneState] = []
        self.positions: list[NDArray[np.float64]] = []
        self.efforts: list[Effort] = []
        self.works: list[Work] = []
        self.departures: list[Departure | None] = []
        self._tally = _Tally()
        self._last = solid.undeformed

    def _guide_along(self, shapes: Sequence[ShapeOnTheWay]) -> Guide:
        solid, ends = self._body.solid, self._body.path.milestones
        guide = Guide(
            self._newton,
            Extrusion(solid, self._mesh).extrude,
            partial(
                settle,
                solid,
                self._absent,
                options=self._settings.petsc_options,
                stopwatch=self._stopwatch,
            ),
        )
        guide.lead_along(
            {
                ends[found.milestone] - found.remaining: placed(
                    found.shape, self._mesh.points, self._held
                )
                for found in shapes
            }
        )
        return guide

    def follow(self) -> str:
        """Follow the path through the milestones; return why it stopped, if it did."""
        path, settings = self._body.path, self._settings
        control = StepControl(
            settings.first_step,
            settings.smallest_step,
            settings.largest_step,
            settings.target_iterations,
        )
        continuation = Continuation(
            self._newton,
            self._search,
            self._body.load,
            control,
            self._tolerances,
            guide=self._guide,
        )
        try:
            for milestone, goal in enumerate(path.milestones):
                for equilibrium in continuation.approach(goal):
                    self._last = equilibrium.state
                    self._note(equilibrium, milestone)
        except PathError as stopped:
            return self._note_failure(stopped)
        except KeyboardInterrupt:
            if self._comm.size > 1 or not self.states:  # the ranks stop at different places
                raise
            return INTERRUPTED
        finally:
            self._newton.close()
        return ""

    def shapes_left(self) -> list[str]:
        """Return a few words for each shape of the start that load steps had to go on without."""
        return [
            f"not followed to {max(self._body.path.stretch(parameter)):.6g} ({reason}): load steps"
            for parameter, reason in self._guide.left
        ]

    def _note(self, equilibrium: Equilibrium, milestone: int) -> None:
        self._tally.add(equilibrium)
        self._report(equilibrium.parameter)
        if not equilibrium.is_goal:
            return
        self.departures.append(equilibrium.departure)
        solid = self._body.solid
        self.positions.append(solid.vertex_positions(self._last))
        self.states.append(
            self._state(
                converged=True,
                reached=self._nominal[milestone],
                residual=equilibrium.residual,
                unstable=equilibrium.unstable_modes,
            )
        )
        self._note_effort()

    def _note_failure(self, stopped: PathError) -> str:
        """Keep the last equilibrium as the state of the milestone that was not reached."""
        self._tally.effort += stopped.effort
        reached = max(self._body.path.stretch(stopped.parameter))
        self.states.append(
            self._state(
                converged=False, reached=reached, residual=math.nan, unstable=UNKNOWN_STABILITY
            )
        )
        self._note_effort()
        return f"stopped at prestretch {reached:.6g}: {stopped}"

    def _note_effort(self) -> None:
        self.efforts.append(self._tally.effort)
        self.works.append(self._stopwatch.taken())
        self._tally = _Tally()

    def _state(
        self, *, converged: bool, reached: float, residual: float, unstable: int
    ) -> MilestoneState:
        solid = self._body.solid
        volume = solid.mesh.volume
        position = solid.vertex_positions(self._last)[volume.interface]
        return MilestoneState(
            position,
            converged,
            reached,
            energy={
                name: solid.layer_energy(layer, self._last) for layer, name in enumerate(self._body.layer_names)
            },
            iterations=self._tally.effort.iterations,
            load_steps=self._tally.load_steps,
            residual=residual,
            wall_time=time.perf_counter() - self._tally.since,
            unstable_modes=unstable,
        )

    def _report(self, parameter: float) -> None:
        if self._progress is not None:
            stretch = max(self._body.path.stretch(parameter))
            self._progress(parameter / self._body.path.milestones[-1], f"prestretch {stretch:.4f}")


@dataclass
class _Tally:
    """What was spent since the last milestone."""

    effort: Effort = field(default_factory=Effort)
    load_steps: int = 0
    since: float = field(default_factory=time.perf_counter)

    def add(self, equilibrium: Equilibrium) -> None:
        self.effort += equilibrium.effort
        self.load_steps += 1


def from_first_rank(comm: MPI.Comm, make: Callable[[], Any]) -> Any:
    """Return on every rank what `make` gives, or raise what it raises, on the first."""
    made: Any = None
    if comm.rank == 0:
        try:
            made = make()
        except BilayerError as error:
            made = error
    made = comm.bcast(made)
    if isinstance(made, BilayerError):
        raise made
    return made


def _made_start(
    start: xr.Dataset | Callable[[PlanarMesh], xr.Dataset] | None, mesh: PlanarMesh, comm: MPI.Comm
) -> tuple[xr.Dataset | None, str]:
    """Return a start, made where it is not there yet, and what is said of it."""
    if start is None or isinstance(start, xr.Dataset):
        return start, began(start)
    try:
        made: xr.Dataset = from_first_rank(comm, lambda: start(mesh))
    except BilayerError as error:
        return None, f"flat, because {error}"
    return made, described(made)


def _checked_mesh(
    specimen: Specimen, mesh: PlanarMesh | None, settings: SolidSettings
) -> PlanarMesh:
    elements = settings.substrate_elements + settings.kirigami_elements
    needed = BYTES_PER_TRIANGLE * elements / 2
    return mesh_within_memory(specimen, mesh, needed, "the finite-element model")


def versions() -> dict[str, str]:
    """Versions of what computes here."""
    return {
        "dolfinx": dolfinx.__version__,
        "basix": basix.__version__,
        "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
    }
