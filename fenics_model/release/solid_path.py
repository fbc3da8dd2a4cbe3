"""The load path of a specimen's solid: what it is made of, its equilibria, how it is kept."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cached_property, partial
from importlib.metadata import version

import basix
import dolfinx
import numpy as np
import xarray as xr
from mpi4py import MPI
from numpy.typing import NDArray
from petsc4py import PETSc

from bilayer.contact.package import PACKAGE as CONTACT_PACKAGE
from bilayer.contact.touching import Touching, measure_touching
from bilayer.errors import ComputationError
from bilayer.geometry.alignment import move_onto_held_points
from bilayer.measures.milestone import Measures, measure
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.contact_variables import contact_dataset
from bilayer.results.start_shapes import StartShapes
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Linearised, Recorded, Saved
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import StretchPair, stretch_of
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import choose_held_nodes
from fenics_model.branches.branch_search import BranchSearch, BranchSearchOutcome, SearchRule
from fenics_model.branches.gradient_flow import FlowRule, GradientFlow
from fenics_model.path.continuation import Continuation, LoadPoint, Tolerances
from fenics_model.path.guide import STAYING, Guide
from fenics_model.path.load_schedule import WEIGHT_WAY, LoadPlace, LoadSchedule
from fenics_model.path.shell_start import Extrusion, relax_guess
from fenics_model.path.step_control import StepControl
from fenics_model.release.body_contact import make_contact
from fenics_model.release.branch_fields import branch_dataset
from fenics_model.release.effort_fields import effort_dataset
from fenics_model.release.layer_states import layer_states
from fenics_model.release.linearisation import SolidLinearisation
from fenics_model.release.saved_path import SavedPath
from fenics_model.release.specimen_solid import (
    asymmetric_lift,
    make_solid,
    natural_state,
)
from fenics_model.release.volume_fields import volume_dataset
from fenics_model.settings import SolidSettings
from fenics_model.solid.numbering import Numbering
from fenics_model.solid.state import State
from fenics_model.solve.effort import Effort
from fenics_model.solve.newton import Newton
from fenics_model.solve.stopwatch import Stopwatch
from fenics_model.solve.touching_newton import TouchingNewton

Array = NDArray[np.float64]

STRETCH = 1.001
REFERENCE_STRETCH = (STRETCH, STRETCH)
"""Tolerances are relative to what is to be balanced, at least to this prestretch."""

RELAXING_ITERATIONS = 4
"""Of a guess with its surface held; one that needs more is no good."""
LEAST_LOAD = 1e-3
"""The same of the loads, over their largest values."""
ROUND_OFF = 1e-12
"""Of the residual of a sheet that is stretched by `STRETCH`, the part that is round-off."""

MOST_AHEAD = 4.0
"""Largest ratio of the change that is expected in a step of time to that in the step before."""
FIRST_DISTANCE = 0.1
"""Of the walk off an unstable milestone, over the carrier's thickness."""


@dataclass(frozen=True, eq=False)
class MilestoneDetails:
    """The data of a milestone for the solver's own variables.

    Parameters
    ----------
    vertices : (v, 3) array of float
        Deformed vertices of the volume mesh, m.
    departure : BranchSearchOutcome or None
        How an unstable equilibrium was left, without its state.
    touching : Touching or None
        How the body touches itself; None if contact is not modelled.
    """

    vertices: Array
    departure: BranchSearchOutcome | None
    touching: Touching | None


class SolidEquilibrium:
    """An equilibrium of the solid; see `bilayer.solvers.contract.Equilibrium`.

    Parameters
    ----------
    path : SolidPath
        On which it is.
    point : LoadPoint
        Where, and its state.
    """

    def __init__(self, path: "SolidPath", point: LoadPoint) -> None:
        self._path, self._body, self._point = path, path.body, point
        self.place = path.loads.place(point.parameter)

    @property
    def share(self) -> float:
        """Part of the way to the target."""
        return self._point.share

    @property
    def effort(self) -> Effort:
        """The work since the equilibrium before."""
        return self._point.effort

    @property
    def stretch(self) -> StretchPair:
        """(lambda_x, lambda_y)."""
        return self.place.stretch

    @property
    def milestone(self) -> Milestone:
        """Its prestretch and loads."""
        return self.place.milestone

    @property
    def responses(self) -> Mapping[str, float]:
        """What each load does its work on, by its name."""
        return self._body.loading.responses(self._point.state, self.place)

    @property
    def residual(self) -> float:
        """Norm of the residual over that of the undeformed mesh; NaN if the path stopped."""
        return self._point.residual

    @property
    def unstable_modes(self) -> int:
        """Number of unstable modes of a target; -1 on the way."""
        return self._point.unstable_modes

    @cached_property
    def vertices(self) -> Array:
        """Deformed vertices of the volume mesh, m, (v, 3)."""
        return self._body.solid.vertex_positions(self._point.state)

    @property
    def position(self) -> Array:
        """The reference surface on the nodes of the planar mesh, m, (n, 3)."""
        return self.vertices[self._body.solid.mesh.volume.reference_surface]

    @property
    def energy(self) -> Mapping[str, float]:
        """Strain energy of each layer, and that of the barrier if contact is modelled, J."""
        layers = {
            name: self._body.solid.layer_energy(layer, self._point.state)
            for layer, name in enumerate(self._body.layer_names)
        }
        contact = self._path.contact
        return (
            layers
            if contact is None
            else layers | {"contact": contact.at(self._point.state).energy}
        )

    def measures(self) -> Measures:
        """Return the measures of the shape."""
        return measure(self._body.specimen, self._body.mesh, self.stretch, self.position)

    def details(self) -> MilestoneDetails:
        """Return the data for `SolidPath.variables`."""
        departure = self._point.departure
        if departure is not None:
            departure = replace(departure, equilibrium=None)
        return MilestoneDetails(self.vertices, departure, self._touching())

    def _touching(self) -> Touching | None:
        contact = self._path.contact
        if contact is None:
            return None
        return measure_touching(contact.skin, contact.barrier, contact.at(self._point.state))

    def layer_states(self) -> list[LayerState]:
        """Return the deformation of each layer, the same on every rank."""
        return layer_states(self._body, self.stretch, self._point.state)

    def save(self) -> Saved:
        """Return all that the path needs to go on from here."""
        return self._path.save()

    def linearised(self) -> Linearised:
        """Return the equations linearised here."""
        return self._path.linearise(self._point)


class SolidPath:
    """Follows the solid of a specimen; see `bilayer.solvers.contract.SpecimenPath`.

    Parameters
    ----------
    specimen : Specimen
        Which is released.
    mesh : PlanarMesh
        The planar mesh, the same on every rank.
    settings : SolidSettings
        Steps and tolerances.
    comm : MPI.Comm
        The ranks.
    shapes : StartShapes or None
        Of another result, the initial guesses.
    start : str
        Their source, in one line.
    progress : callable, optional
        Told what is being done.
    """

    def __init__(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        settings: SolidSettings,
        comm: MPI.Comm,
        shapes: StartShapes | None,
        start: str,
        progress: Progress | None = None,
    ) -> None:
        self._progress = progress
        self.body = make_solid(specimen, mesh, settings, comm)
        self.loads = LoadSchedule(
            scales=[load.scale for load in specimen.loads],
            weight_way=_weight_way(specimen),
            time_way=settings.first_step,
        )
        self.mesh, self.comm = mesh, comm
        self.contact = make_contact(self.body)
        self._shapes, self._start = shapes, start
        self._loaded, self._visited = 0.0, 0
        self._nodes = choose_held_nodes(mesh.points, float(specimen.is_placed), mesh.centroid)
        with ExitStack() as stack:
            self._newton = stack.enter_context(self._make_newton())
            self._search = self._make_search()
            self._guide = self._make_guide()
            self._continuation = self._make_continuation()
            self._resources = stack.pop_all()

    def _make_newton(self) -> Newton:
        solid, settings = self.body.solid, self.body.settings
        make = Newton if self.contact is None else partial(TouchingNewton, contact=self.contact)
        return make(
            solid,
            [*solid.absent_pressures(), *self.body.loading.held(self._nodes)],
            iteration_limit=settings.iteration_limit,
            options=settings.petsc_options,
            stopwatch=Stopwatch(),
            tell=self._tell,
        )

    def _make_guide(self) -> Guide:
        solid = self.body.solid
        relax = partial(
            relax_guess,
            solid,
            solid.absent_pressures(),
            iteration_limit=RELAXING_ITERATIONS,
            options=self.body.settings.petsc_options,
            stopwatch=self._newton.stopwatch,
        )
        extrude = Extrusion(solid, self.mesh).extrude
        rule = STAYING if self._search.stays else None
        return Guide(self._newton, extrude, relax, self._search.flow, rule)

    def _make_continuation(self) -> Continuation:
        settings = self.body.settings
        self.body.prestretch(self.body.specimen, REFERENCE_STRETCH)
        least, round_off = self._newton.residual_norm(self.body.solid.undeformed), 0.0
        if self.body.specimen.loads:
            least, round_off = max(least, self._least_of_loads()), self._round_off()
        return Continuation(
            self._newton,
            self._search,
            self._load,
            StepControl(
                settings.first_step,
                settings.smallest_step,
                settings.largest_step,
                settings.target_iterations,
            ),
            Tolerances(settings.tolerance, settings.path_tolerance, least, round_off),
            guide=self._guide,
        )

    def _least_of_loads(self) -> float:
        """Return the residual of the undeformed mesh under a small part of all loads."""
        values = tuple(LEAST_LOAD * load.scale for load in self.body.specimen.loads)
        held, let_go = (1.0,) * len(values), (0.0,) * len(values)
        self.body.load(LoadPlace((1.0, 1.0), 0.0, 0.0, values, held, let_go))
        return self._newton.residual_norm(self.body.solid.undeformed)

    def _round_off(self) -> float:
        """Return the residual that no equilibrium can be asked to go below, N.

        It goes with the stiffness of the sheet, beside which a load may be very small.
        """
        for layer in self.body.solid.layers:
            layer.natural.value = natural_state(((STRETCH, 0.0), (0.0, STRETCH)), "natural")
        return ROUND_OFF * self._newton.residual_norm(self.body.solid.undeformed)

    def _make_search(self) -> BranchSearch:
        specimen, settings = self.body.specimen, self.body.settings
        radius, carrier = specimen.characteristic_length, specimen.carrier
        flow = GradientFlow(
            self._newton,
            first_viscosity=carrier.material.shear_modulus * carrier.thickness / radius**3,
            escape=FIRST_DISTANCE * carrier.thickness,
            rule=FlowRule(step_limit=settings.flow_steps),
        )
        return BranchSearch(
            self._newton,
            flow,
            first_distance=FIRST_DISTANCE * carrier.thickness,
            side=asymmetric_lift(self.body),
            rule=SearchRule(choice=settings.branch),
        )

    def _load(self, parameter: float) -> None:
        self.body.load(self.loads.place(parameter))
        self._loaded = parameter

    def _tell(self, doing: str) -> None:
        if self._progress is not None:
            self._progress(0.0, f"prestretch {max(self.loads.stretch(self._loaded)):.6g}: {doing}")

    def close(self) -> None:
        """Free what PETSc holds."""
        self._resources.close()

    @property
    def start(self) -> str:
        """The source of the initial guesses, and the shapes that were rejected."""
        left = [
            f"not followed to {max(self.loads.stretch(parameter)):.6g} ({reason}): load steps"
            for parameter, reason in self._guide.rejected
        ]
        return "; ".join([self._start, *left])

    @property
    def versions(self) -> dict[str, str]:
        """Versions of what computes."""
        of_contact = {} if self.contact is None else {CONTACT_PACKAGE: version(CONTACT_PACKAGE)}
        return {
            "dolfinx": dolfinx.__version__,
            "basix": basix.__version__,
            "petsc": ".".join(str(part) for part in PETSc.Sys.getVersion()),
        } | of_contact

    def approach(self, target: Milestone) -> Iterator[SolidEquilibrium]:
        """Go to a milestone; see `bilayer.solvers.contract.Path`."""
        times = self._times_to_go()
        for number, time in enumerate(times):
            for point in self._in_time(target, time):
                share = (number + point.share) / len(times) if len(times) > 1 else point.share
                yield SolidEquilibrium(self, replace(point, share=share))

    def _times_to_go(self) -> list[float]:
        """Return the ends of the steps of time to the next target, s; that of the release first."""
        schedule = self.body.specimen.schedule
        if schedule is None:
            return [0.0]
        self._visited += 1
        series = [layer.relaxation for layer in self.body.specimen.layers]
        return schedule.steps_to(self._visited - 1, series)

    def _in_time(self, target: Milestone, time: float) -> Iterator[LoadPoint]:
        """Go to a target at the end of a step of time, which is remembered."""
        if time > 0:
            self._continuation.begin_anew(self._slope_in_time(time))
        for point in self._go_on(target, time):
            if point.share == 1:
                self.body.remember(self.loads.place(point.parameter), point.state)
            yield point

    def _slope_in_time(self, time: float) -> Array | None:
        """Return the expected change in a step of time, over its length on the path.

        The state changes with the stress that relaxes, as it did in the step before. With loads,
        which have ways of their own, nothing is expected.
        """
        known = self._continuation.predictor.known[-2:]
        if len(known) < 2 or self.body.specimen.loads:
            return None
        (before, first), (here, last) = known
        left = [self._stress_left(t) for t in (*map(self._time_at, (before, here)), time)]
        if left[0] <= left[1]:
            return None
        ratio = min(MOST_AHEAD, (left[1] - left[2]) / (left[0] - left[1]))
        return ratio / self.body.settings.first_step * (last - first)

    def _time_at(self, parameter: float) -> float:
        return self.loads.place(parameter).time

    def _stress_left(self, time: float) -> float:
        """Return the shares of all layers' stresses that are left of one that is held, summed."""
        layers = self.body.specimen.layers
        return sum(float(layer.relaxation.stress_left(time)) for layer in layers)

    def _go_on(self, target: Milestone, time: float) -> Iterator[LoadPoint]:
        """Follow the equilibria to a target at a time."""
        here = self._continuation.parameter
        if here < self.loads.end:
            self.loads.leave_at(here)
        state, place = self._continuation.predictor.last, self.loads.place(here)
        reached = self.body.loading.note(state, place)
        begin, goal = self.loads.last, self.loads.add_target(target, reached, time)
        shapes = {} if time > 0 else self._shapes_between(begin, stretch_of(target), goal)
        if self.loads.turns_back and time == 0:  # over its own equilibria, which lead better
            self._continuation.predictor.turn_back()
            shapes = {}
        self._guide.use_shapes(shapes)
        yield from self._continuation.approach(goal)

    def _shapes_between(
        self, begin: StretchPair, target: StretchPair, goal: float
    ) -> dict[float, Array]:
        """Return the start's shapes on the way to a target, by path parameter, held as it is."""
        if self._shapes is None:
            return {}
        found = self._shapes.take_shapes(begin, target)
        if not found and len(self.loads.milestones) == 1:
            found = [self._shapes.take_nearest(target)]
        if self.body.specimen.supports or self.body.specimen.is_laid:
            return {goal - shape.remaining: shape.shape for shape in found}
        return {
            goal - shape.remaining: move_onto_held_points(
                shape.shape, self.mesh.points, self._nodes
            )
            for shape in found
        }

    def stopped(self) -> SolidEquilibrium:
        """Return the last equilibrium, with the work done in vain since."""
        return SolidEquilibrium(self, self._continuation.stopped())

    def linearise(self, point: LoadPoint) -> SolidLinearisation:
        """Return the equations linearised at a point of the path, until it goes on."""
        if self.body.memory is not None:
            raise ComputationError("linearised: not of layers that relax, expected no [time]")
        place = self.loads.place(point.parameter)
        return SolidLinearisation(self.body, self._newton, self.numbering, point.state, place)

    @cached_property
    def numbering(self) -> Numbering:
        """Of all dofs, whatever the number of ranks."""
        return Numbering(self.body.solid)

    def save(self) -> Saved:
        """Return the state of the path, the same on every rank."""
        memory = self.body.memory
        remembered = {} if memory is None else memory.save()
        path = SavedPath.of(self._continuation, self._guide, self.loads, self._shapes, self._start)
        return path.as_arrays(self.numbering) | {f"memory.{k}": v for k, v in remembered.items()}

    def restore(self, saved: Saved) -> None:
        """Be where the path was saved; it is new."""
        known = SavedPath.from_arrays(saved, self.numbering)
        for target, time in zip(known.targets, known.times, strict=True):
            self.loads.add_target(target, time=time)
        known.restore(self._continuation, self._guide)
        self._shapes, self._start = known.shapes, known.start
        self._restore_memory(saved)
        self._load(self._continuation.parameter)

    def restore_neighbour(
        self, saved: Saved, target: Milestone | None = None, change: Array | None = None
    ) -> None:
        """Be near the state that was saved of a specimen nearby, moved onto the held points."""
        known = SavedPath.from_arrays(saved, self.numbering)
        for earlier, time in zip(known.targets, known.times, strict=True):
            self.loads.add_target(earlier, time=time)
        parameter, _ = known.equilibria[-1]
        if target is not None:
            parameter = self.loads.add_target(target)
        here = np.asarray(saved["equilibrium"][-1])
        values = self._onto_held_points(here if change is None else here + change)
        self._continuation.begin_at(parameter, State(self.numbering.spread(values)))
        self._start = known.start
        self._load(parameter)

    def _onto_held_points(self, values: Array) -> Array:
        """Return the values of all dofs after a rigid motion of the body onto its held points."""
        volume = self.body.solid.mesh.volume
        flat = self.numbering.places(volume.points)
        moved = values.copy()
        displacements = moved[: flat.size].reshape(flat.shape)
        a, b, c = (int(vertex) for vertex in volume.reference_surface[list(self._nodes)])
        shape = flat + displacements
        displacements[:] = move_onto_held_points(shape, flat[:, :2], (a, b, c)) - flat
        return moved

    def _restore_memory(self, saved: Saved) -> None:
        memory, schedule = self.body.memory, self.body.specimen.schedule
        if schedule is not None:
            self._visited = schedule.passed(self.loads.times[-1])
        if memory is not None:
            prefix = "memory."
            names = [name for name in saved if name.startswith(prefix)]
            memory.restore({name.removeprefix(prefix): saved[name] for name in names})

    def variables(self, milestones: Sequence[Recorded | None]) -> xr.Dataset:
        """Return the volume mesh, the work and the branches by milestone; on the first rank."""
        count = len(self.body.specimen.prestretch.milestones)
        details = [None if tried is None else tried.details for tried in milestones]
        volume = volume_dataset(
            self.body.solid.mesh.volume,
            self.body.layer_names,
            [None if found is None else found.vertices for found in details],
            count,
        )
        efforts = [None if tried is None else tried.effort for tried in milestones]
        departures = [None if found is None else found.departure for found in details]
        whole = volume.merge(effort_dataset(efforts, count)).merge(
            branch_dataset(departures, count)
        )
        if self.contact is None:
            return whole
        touching = [None if found is None else found.touching for found in details]
        return whole.merge(contact_dataset(touching, len(self.mesh.triangles), count))


def _weight_way(specimen: Specimen) -> float:
    """Return the way over which the weight comes on; what lies on a table has it at once."""
    return WEIGHT_WAY if specimen.gravity and not specimen.is_laid else 0.0
