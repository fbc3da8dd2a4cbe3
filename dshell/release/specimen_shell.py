"""A specimen as a shell under loads: what its load path needs to know of it, and no more.

The load is a milestone: the prestretch (lambda_x, lambda_y), then the value of each load.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.barrier import Barrier
from bilayer.contact.limits import barrier_range, barrier_stiffness
from bilayer.contact.several import SkinBarrier
from bilayer.contact.skin import BondedBody
from bilayer.contact.skin_map import SkinMap
from bilayer.contact.specimen_obstacles import with_obstacles
from bilayer.geometry.alignment import align, best_rotation, move_onto_held_points
from bilayer.geometry.surface import Surface
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.parts import clamped_edges, supported_coordinates
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.table import milestone_text
from bilayer.specimen.load import Milestone
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair, stretch_of
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import pins_besides
from dshell.energies.assembly import Energy, deform, gradient_of
from dshell.energies.skin_contact import SkinContact
from dshell.models.masses import lumped_masses
from dshell.models.morley import MorleyModel
from dshell.models.reference_surface import reference_surface_over
from dshell.release.loading import ShellLoading, unloaded
from dshell.release.rigid_motion import choose_held_nodes
from dshell.release.shell_memory import ShellMemory
from dshell.solve.newton import Body

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactLimits:
    """The barrier of a sheet that may touch itself.

    Parameters
    ----------
    range : float
        Distance from which on nothing acts, over the thickness of all layers.
    """

    range: float


ROUND_OFF = 1e-13
"""Residual force, over E t R of the stiffer layer, that no equilibrium can be asked to go below."""
ESCAPE = 0.1
"""Distance by which an unstable equilibrium is left, over the carrier's thickness."""


class ShellModel(Protocol):
    """A model as the load path sees it: its degrees of freedom, and its energies by prestretch."""

    extra_dofs: int
    """Degrees of freedom behind the nodes' coordinates."""
    extra_flat: Array
    """Their values in the flat state, m, shape (extra_dofs,)."""
    fixed_dofs: NDArray[np.int64]
    """Those that never change, by their places in the state."""
    fold_count: int
    """Folds whose whole turns stand behind these; see `dshell.energies.whole_turns`."""

    def energies(self, stretch: StretchPair) -> Sequence[Energy]:
        """Return the energies at a prestretch, always on the same stencils."""

    def reference_height(self, stretch: StretchPair) -> Array | float:
        """Return the flat height of the reference surface above the nodes, m, shape (n,) or ()."""

    def energy_terms(self, stretch: StretchPair, state: Array) -> Mapping[str, float]:
        """Return the energies that a result lists, J."""

    def layer_states(self, energies: Sequence[Any], state: Array, turn: Array) -> list[LayerState]:
        """Return the deformation of each layer, none if the model has no layers.

        `energies` are those of the model, with what the layers remember.
        `turn`, (3, 3), is the rotation from the axes of the state to those of the result.
        """


class SpecimenShell:
    """A specimen on its planar mesh by one of the models; see `dshell.release.static.ShellProblem`.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.
    make_model : callable
        Returns the model of a specimen on a mesh.
    tolerance : float
        Norm of the residual force at an equilibrium, over that of the flat state.
    """

    def __init__(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        make_model: Callable[[Specimen, PlanarMesh], ShellModel],
        tolerance: float,
        contact: ContactLimits | None = None,
    ) -> None:
        self.specimen, self.mesh = specimen, mesh
        self._make_model, self._tolerance = make_model, tolerance
        self._contact_limits = contact
        self.memory = None if specimen.schedule is None else ShellMemory(specimen.schedule.hold)
        self._contact_at: tuple[StretchPair, SkinContact] | None = None
        self._held_nodes = choose_held_nodes(specimen, mesh)
        self.unloaded = unloaded(specimen)
        self.loading = ShellLoading(specimen, mesh)

    @cached_property
    def model(self) -> ShellModel:
        """The model."""
        return self._make_model(self.specimen, self.mesh)

    @cached_property
    def held(self) -> NDArray[np.int64]:
        """Entries of the state that are no unknowns.

        Held coordinates, what the model never changes, and whole turns of folds.
        """
        first_turn = 3 * len(self.mesh.points) + self.model.extra_dofs
        turns = first_turn + np.arange(self.model.fold_count)
        return np.concatenate([self._held_coordinates, self.model.fixed_dofs, turns])

    @cached_property
    def _held_coordinates(self) -> NDArray[np.int64]:
        """Coordinates that supports hold, and the pins that are needed besides."""
        held = supported_coordinates(self.specimen, self.mesh)
        clamped = clamped_edges(self.specimen, self.mesh)
        pins = pins_besides(self.mesh.points, held, clamped, self._held_nodes)
        if self.specimen.is_laid:
            pins = pins[pins[:, 1] < 2]
        return np.concatenate([held, pins]) @ np.array([3, 1])

    @property
    def least_force(self) -> float:
        """See `ShellProblem`: round-off over the tolerance."""
        layers = self.specimen.layers
        stiffness = max(layer.material.young_modulus * layer.thickness for layer in layers)
        return ROUND_OFF * stiffness * self.specimen.characteristic_length / self._tolerance

    @property
    def escape(self) -> float:
        """Distance by which an unstable equilibrium is left along its mode, m."""
        return ESCAPE * self.specimen.carrier.thickness

    def of(self, specimen: Specimen) -> "SpecimenShell":
        """Return another specimen on the same mesh, held at the same nodes."""
        other = self._like(specimen, self.mesh)
        if isinstance(self.model, MorleyModel):
            other.model = self.model.with_specimen(specimen)
        elif specimen == self.specimen:
            other.model = self.model
        return other

    def on(self, mesh: PlanarMesh) -> "SpecimenShell":
        """Return the same specimen with the nodes of its mesh elsewhere, held at the same nodes."""
        return self._like(self.specimen, mesh)

    def _like(self, specimen: Specimen, mesh: PlanarMesh) -> "SpecimenShell":
        other = SpecimenShell(
            specimen, mesh, self._make_model, self._tolerance, self._contact_limits
        )
        other._held_nodes = self._held_nodes
        return other

    def way(self, start: Milestone, end: Milestone) -> float:
        """Return the larger change of the two stretches between two milestones."""
        pairs = zip(stretch_of(start), stretch_of(end), strict=True)
        return max(abs(after - before) for before, after in pairs)

    def name_of(self, milestone: Milestone) -> str:
        """Return a milestone in a few words."""
        return milestone_text(self.specimen, milestone)

    def flat(self, milestone: Milestone) -> Array:
        """Return the flat bonded state, the model's surface at z = 0."""
        return self._state_of(np.column_stack([self.mesh.points, np.zeros(len(self.mesh.points))]))

    def body(self, milestone: Milestone) -> Body:
        """Return the shell at a milestone, under its weight and loads."""
        stretch = stretch_of(milestone)
        masses = lumped_masses(self.specimen, self.mesh, stretch)
        load = self.loading.forces(milestone)
        load[:, 2] -= self.specimen.gravity * masses
        energies = [*self._elastic(milestone), *self.loading.energies(milestone)]
        rest = np.zeros(self.model.extra_dofs + self.model.fold_count)
        dead = np.concatenate([load.reshape(-1), rest])
        return Body(energies, dead, self.contact(stretch))

    def _elastic(self, milestone: Milestone) -> Sequence[Energy]:
        """Return the model's energies at a milestone, with what the layers remember."""
        plain: Any = self.model.energies(stretch_of(milestone))
        if self.memory is None:
            return plain  # type: ignore[no-any-return]
        return self.memory.remembering(plain, self.flat(milestone))

    def arrive(self, milestone: Milestone, state: Array) -> None:
        """Keep what the layers remember in an equilibrium at the end of a step of time."""
        if self.memory is not None:
            blocks: Any = self.model.energies(stretch_of(milestone))
            self.memory.arrive(blocks, self.flat(milestone), state)

    @property
    def has_contact(self) -> bool:
        """Whether the sheet presses on itself."""
        return self._contact_limits is not None

    def contact(self, stretch: StretchPair) -> SkinContact | None:
        """Return the contact of the sheet with itself at a prestretch, None if it has none."""
        if self._contact_limits is None:
            return None
        if self._contact_at is None or self._contact_at[0] != stretch:
            skin = self._skin.at_heights_of(self._bonded_body(stretch))
            nodes = len(self.mesh.points)
            self._contact_at = stretch, SkinContact(skin, self._barrier, nodes)
        return self._contact_at[1]

    @cached_property
    def _skin(self) -> SkinMap:
        return SkinMap.of(self._bonded_body(UNSTRETCHED))

    @cached_property
    def _barrier(self) -> SkinBarrier:
        limits = self._contact_limits
        assert limits is not None
        flat = flat_surface(self.mesh).points
        itself = Barrier.of(
            self._skin,
            flat,
            range=barrier_range(self.specimen, limits.range),
            stiffness=barrier_stiffness(self.specimen),
        )
        skin = Surface(self._skin.points(flat), self._skin.triangles)
        return with_obstacles(itself, self.specimen, skin)

    def _bonded_body(self, stretch: StretchPair) -> BondedBody:
        """Return the layers at their heights over the model's surface."""
        body = BondedBody.of(self.specimen, self.mesh, stretch)
        above = float(self.model.reference_height(stretch))
        sheets = [
            replace(sheet, bottom=sheet.bottom + above, top=sheet.top + above)
            for sheet in body.sheets
        ]
        return replace(body, sheets=sheets)

    def masses(self, milestone: Milestone) -> Array:
        """Return the mass behind each degree of freedom, kg; 0 behind those that are no nodes'."""
        masses = np.repeat(lumped_masses(self.specimen, self.mesh, stretch_of(milestone)), 3)
        return np.concatenate([masses, np.zeros(self.model.extra_dofs + self.model.fold_count)])

    def forces(self, milestone: Milestone, state: Array) -> Array:
        """Return the residual force on every degree of freedom, N; 0 on those that are held."""
        body = self.body(milestone)
        forces = gradient_of(deform(body.energies, state)) - body.load
        if body.contact is not None:
            forces += body.contact.at(state).gradient
        forces[self.held] = 0.0
        return forces

    def surface(self, state: Array) -> Array:
        """Return the nodes of the model's surface, m, shape (n, 3)."""
        return state[: 3 * len(self.mesh.points)].reshape(-1, 3)

    def reference_surface(self, milestone: Milestone, state: Array) -> Array:
        """Return the reference surface where the nodes are held, m, shape (n, 3)."""
        mesh, height = self.mesh, self.model.reference_height(stretch_of(milestone))
        return reference_surface_over(self.surface(state), mesh.triangles, mesh.areas, height)

    def position(self, milestone: Milestone, state: Array) -> Array:
        """Return the reference surface as a result has it, m, shape (n, 3).

        A shape that nothing outside holds has no orientation of its own: it is turned to lie on the
        flat sheet as well as it can, and not as the held nodes happen to tilt it. One with supports
        or loads is seen from the flat reference surface.
        """
        shape = self.reference_surface(milestone, state)
        if self.specimen.supports or self.specimen.loads:
            return shape - self._flat_level(milestone)
        if self.specimen.is_placed:
            return shape
        flat = flat_surface(self.mesh)
        return align(shape, flat.points, flat.node_areas)

    def layer_states(self, milestone: Milestone, state: Array) -> list[LayerState]:
        """Return the deformation of each layer, with rotations in the axes of `position`."""
        weights = flat_surface(self.mesh).node_areas
        shape = self.reference_surface(milestone, state)
        turn = best_rotation(shape, self.position(milestone, state), weights).as_matrix()
        return self.model.layer_states(self._elastic(milestone), state, turn)

    def state_near(self, shape: Array, milestone: Milestone) -> Array:
        """Return the state whose reference surface is near a given one.

        That may be in any position, unless supports hold it where it is.
        """
        mesh, depth = self.mesh, -self.model.reference_height(stretch_of(milestone))
        if self.specimen.supports:
            shape = shape + self._flat_level(milestone)
        surface = reference_surface_over(shape, mesh.triangles, mesh.areas, depth)
        if not self.specimen.supports:
            surface = self.move_to_held(surface)
        state = self._state_of(surface)
        state[self.held] = self.flat(milestone)[self.held]
        return state

    def _flat_level(self, milestone: Milestone) -> Array:
        """Return the way from the model's flat surface to the reference surface, m."""
        height = np.asarray(self.model.reference_height(stretch_of(milestone)))
        return np.multiply.outer(height, np.array([0.0, 0.0, 1.0]))

    def move_to_held(self, surface: Array) -> Array:
        """Return the nodes of the model's surface after the rigid motion to where it is held."""
        return move_onto_held_points(surface, self.mesh.points, self._held_nodes)

    def _state_of(self, nodes: Array) -> Array:
        """Return the state of nodes at (n, 3), m, with every other entry as it is flat."""
        return np.concatenate(
            [nodes.reshape(-1), self.model.extra_flat, np.zeros(self.model.fold_count)]
        )
