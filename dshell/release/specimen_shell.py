"""A specimen as a shell under loads: what its load path needs to know of it, and no more.

The load is the prestretch (lambda_x, lambda_y).
"""

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.alignment import align, move_onto_held_points
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.specimen.prestretch import UNSTRETCHED, StretchPair
from bilayer.specimen.specimen import Specimen
from dshell.energies.assembly import Energy, deform, gradient_of
from dshell.models.masses import lumped_masses
from dshell.models.reference_surface import reference_surface_over
from dshell.release.rigid_motion import choose_held_nodes, held_coordinates
from dshell.solve.newton import Body

Array = NDArray[np.float64]

ROUND_OFF = 1e-13
"""Residual force, over E t R of the stiffer layer, that no equilibrium can be asked to go below."""
ESCAPE = 0.1
"""Distance by which an unstable equilibrium is left, over the carrier's thickness."""


class ShellModel(Protocol):
    """A model as the load path sees it: its degrees of freedom, and its energies by prestretch."""

    extra_dofs: int
    """Degrees of freedom behind the nodes' coordinates."""
    fold_count: int
    """Folds whose whole turns stand behind these; see `dshell.energies.whole_turns`."""

    def energies(self, stretch: StretchPair) -> Sequence[Energy]:
        """Return the energies at a prestretch, always on the same stencils."""

    def reference_height(self, stretch: StretchPair) -> Array | float:
        """Return the flat height of the reference surface above the nodes, m, shape (n,) or ()."""

    def energy_terms(self, stretch: StretchPair, state: Array) -> Mapping[str, float]:
        """Return the energies that a result lists, J."""


class SpecimenShell:
    """A specimen on its planar mesh by one of the models; see `dshell.release.static.ShellProblem`.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.
    make_model : callable
        Returns the model of a specimen on that mesh.
    tolerance : float
        Norm of the residual force at an equilibrium, over that of the flat state.
    """

    unloaded = UNSTRETCHED

    def __init__(
        self,
        specimen: Specimen,
        mesh: PlanarMesh,
        make_model: Callable[[Specimen], ShellModel],
        tolerance: float,
    ) -> None:
        self.specimen, self.mesh = specimen, mesh
        self._make_model, self._tolerance = make_model, tolerance
        self._held_nodes = choose_held_nodes(specimen, mesh)

    @cached_property
    def model(self) -> ShellModel:
        """The model."""
        return self._make_model(self.specimen)

    @cached_property
    def held(self) -> NDArray[np.int64]:
        """Entries of the state that are no unknowns: held coordinates, and whole turns of folds."""
        first_turn = 3 * len(self.mesh.points) + self.model.extra_dofs
        turns = first_turn + np.arange(self.model.fold_count)
        return np.concatenate([held_coordinates(self._held_nodes), turns])

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
        other = SpecimenShell(specimen, self.mesh, self._make_model, self._tolerance)
        other._held_nodes = self._held_nodes
        if specimen == self.specimen:
            other.model = self.model
        return other

    def flat(self, stretch: StretchPair) -> Array:
        """Return the flat bonded state, the model's surface at z = 0."""
        return self._state_of(np.column_stack([self.mesh.points, np.zeros(len(self.mesh.points))]))

    def body(self, stretch: StretchPair) -> Body:
        """Return the shell at a prestretch, with its weight."""
        masses = lumped_masses(self.specimen, self.mesh, stretch)
        load = np.zeros((len(masses), 3))
        load[:, 2] = -self.specimen.gravity * masses
        return Body(self.model.energies(stretch), self._state_of(load))

    def masses(self, stretch: StretchPair) -> Array:
        """Return the mass behind each degree of freedom, kg; 0 behind those that are no nodes'."""
        masses = np.repeat(lumped_masses(self.specimen, self.mesh, stretch), 3)
        return np.concatenate([masses, np.zeros(self.model.extra_dofs + self.model.fold_count)])

    def forces(self, stretch: StretchPair, state: Array) -> Array:
        """Return the residual force on every degree of freedom, N; 0 on those that are held."""
        body = self.body(stretch)
        forces = gradient_of(deform(body.energies, state)) - body.load
        forces[self.held] = 0.0
        return forces

    def surface(self, state: Array) -> Array:
        """Return the nodes of the model's surface, m, shape (n, 3)."""
        return state[: 3 * len(self.mesh.points)].reshape(-1, 3)

    def reference_surface(self, stretch: StretchPair, state: Array) -> Array:
        """Return the reference surface where the nodes are held, m, shape (n, 3)."""
        mesh, height = self.mesh, self.model.reference_height(stretch)
        return reference_surface_over(self.surface(state), mesh.triangles, mesh.areas, height)

    def position(self, stretch: StretchPair, state: Array) -> Array:
        """Return the reference surface as a result has it, m, shape (n, 3).

        A shape without weight has no orientation of its own: it is turned to lie on the flat sheet
        as well as it can, and not as the held nodes happen to tilt it.
        """
        shape = self.reference_surface(stretch, state)
        if self.specimen.gravity > 0:
            return shape
        flat = flat_surface(self.mesh)
        return align(shape, flat.points, flat.node_areas)

    def state_near(self, shape: Array, stretch: StretchPair) -> Array:
        """Return the state whose reference surface is near a given one, in any position."""
        mesh, depth = self.mesh, -self.model.reference_height(stretch)
        surface = reference_surface_over(shape, mesh.triangles, mesh.areas, depth)
        return self._state_of(move_onto_held_points(surface, mesh.points, self._held_nodes))

    def _state_of(self, nodes: Array) -> Array:
        """Return the state of nodes at (n, 3), m, with every other entry 0."""
        return np.concatenate(
            [nodes.reshape(-1), np.zeros(self.model.extra_dofs + self.model.fold_count)]
        )
