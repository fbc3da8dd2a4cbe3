"""The supports and loads of a specimen on its solid.

Forces and imposed displacements act at the reference surface, pressures on the lower skin. A
clamped part is held in the plane through its whole thickness, so that its fibres stay upright, and
across it at the reference surface alone, so that it may become thinner.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.parts import (
    AXES,
    check_pressed,
    clamped_edges,
    edges_of,
    faces_of,
    nodes_of,
    supported_coordinates,
)
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.load import Load
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import HeldNodes, pins_besides
from bilayer.specimen.supported import Support
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.path.load_schedule import LoadPlace
from fenics_model.solid.nodal_terms import NodalForce
from fenics_model.solid.skin_pressure import SkinPressure
from fenics_model.solid.solid import Solid
from fenics_model.solid.state import State

Array = NDArray[np.float64]
Pairs = NDArray[np.int64]
SIMPSON = (1 / 6, 4 / 6)
"""Shares of an edge's load at its ends and in its middle."""


@dataclass(frozen=True, eq=False)
class BodyLoad:
    """A dead force per natural volume, made before the solid.

    Parameters
    ----------
    value : dolfinx Constant
        N/m3.
    vector, unit : UFL vectors
        The force: the value where the load acts, along its direction; and that for a value of 1.
    """

    value: fem.Constant
    vector: Any
    unit: Any


def body_load(load: Load, layered: LayeredMesh, planar: PlanarMesh) -> BodyLoad:
    """Return a body force on the cells over the triangles where it acts."""
    chosen = planar.triangles[faces_of(load.part, planar, _field(load))]
    nodes = layered.volume.planar_nodes[layered.cell_vertices]
    spread = np.sort(nodes, axis=1)
    is_new = np.diff(spread, axis=1, prepend=-1) != 0
    corners = spread[is_new].reshape(-1, 3)
    key = np.array([len(planar.points) ** 2, len(planar.points), 1])
    inside = np.isin(corners @ key, np.sort(chosen, axis=1) @ key)
    where = fem.Function(fem.functionspace(layered.mesh, ("DG", 0)))
    where.x.array[: len(inside)] = inside
    where.x.scatter_forward()
    value = fem.Constant(layered.mesh, default_scalar_type(0.0))
    direction = fem.Constant(layered.mesh, np.array(load.direction, dtype=default_scalar_type))
    return BodyLoad(value, value * where * direction, where * direction)


def skin_pressure(load: Load, layered: LayeredMesh, planar: PlanarMesh) -> SkinPressure:
    """Return the pressure of a load on the lower skin."""
    triangles = planar.triangles[faces_of(load.part, planar, _field(load))]
    return SkinPressure(layered, layered.volume.lowest_faces(triangles))


@dataclass(frozen=True, eq=False)
class _Grip:
    """The dofs along one axis that a displacement holds."""

    dofs: NDArray[np.int64]
    sign: float
    stiffness: float


class SolidLoading:
    """The supports and loads of a specimen; sets the values that act.

    Parameters
    ----------
    solid : Solid
        On which they act.
    specimen, planar
        Whose they are, on which planar mesh.
    bodies, pressures
        Those of the body forces and pressures among the loads, in their order.

    Raises
    ------
    InputError
        A displacement is along none of the axes, or what a pressure acts on is not held.
    """

    def __init__(
        self,
        solid: Solid,
        specimen: Specimen,
        planar: PlanarMesh,
        bodies: Sequence[BodyLoad],
        pressures: Sequence[SkinPressure],
    ) -> None:
        self._solid, self._specimen, self._planar = solid, specimen, planar
        check_pressed(specimen, planar)
        self._bodies = dict(zip(_names(specimen, "body_force"), bodies, strict=True))
        self._pressures = dict(zip(_names(specimen, "pressure"), pressures, strict=True))
        self._forces = {
            load.name: self._force(load)
            for load in specimen.loads
            if load.kind in ("force", "line_force")
        }
        self._grips = {
            load.name: self._grip(load) for load in specimen.loads if load.kind == "displacement"
        }
        self._held_before: dict[str, Array] = {
            name: np.zeros(len(grip.dofs)) for name, grip in self._grips.items()
        }

    def act(self, place: LoadPlace) -> None:
        """Let the loads of a place on the path act."""
        nodal = self._solid.nodal
        nodal.clear()
        loads = self._specimen.loads
        for load, value, grip, force in zip(
            loads, place.values, place.grips, place.forces, strict=True
        ):
            if load.name in self._pressures:
                self._pressures[load.name].value.value = value
            elif load.name in self._bodies:
                self._bodies[load.name].value.value = value
            elif load.name in self._forces:
                for part in self._forces[load.name]:
                    nodal.push(part, value)
            else:
                held = self._grips[load.name]
                nodal.grip(held.dofs, grip * held.stiffness, held.sign * value)
                nodal.push(NodalForce(held.dofs, self._held_before[load.name]), force)

    def note(self, state: State, place: LoadPlace) -> tuple[float, ...]:
        """Note the forces that hold displacements now; return the displacements, 0 of others."""
        reached = []
        for load, value, hold in zip(self._specimen.loads, place.values, place.grips, strict=True):
            if load.name not in self._grips:
                reached.append(0.0)
                continue
            grip = self._grips[load.name]
            apart = grip.sign * value - state.values[grip.dofs]
            self._held_before[load.name] = hold * grip.stiffness * apart
            reached.append(self._mean(grip, state))
        return tuple(reached)

    def responses(self, state: State, place: LoadPlace) -> dict[str, float]:
        """Return what each load does its work on, by its name, the same on every rank."""
        nodal, found = self._solid.nodal, {}
        for load, value, hold in zip(self._specimen.loads, place.values, place.grips, strict=True):
            if load.name in self._pressures:
                found[load.name] = self._solid.swept_volume(self._pressures[load.name], state)
            elif load.name in self._bodies:
                found[load.name] = self._body_response(load, state)
            elif load.name in self._forces:
                parts = self._forces[load.name]
                found[load.name] = sum(nodal.work(part, state.values) for part in parts)
            else:
                grip = self._grips[load.name]
                apart = value - grip.sign * state.values[grip.dofs]
                found[load.name] = nodal.total(hold * grip.stiffness * apart)
        return found

    def held(self, nodes: HeldNodes) -> list[fem.DirichletBC]:
        """Return the constraints of the supports, and of the pins that are needed besides."""
        planar, volume = self._planar, self._solid.mesh.volume
        coordinates = supported_coordinates(self._specimen, planar)
        clamped = clamped_edges(self._specimen, planar)
        pins = pins_besides(planar.points, coordinates, clamped, nodes)
        if self._specimen.is_laid:
            pins = pins[pins[:, 1] < 2]  # the table holds it across
        surface = volume.reference_surface
        held = [bc for support in self._specimen.supports for bc in self._supported(support)]
        return held + self._solid.held_points([(surface[node], axis) for node, axis in pins])

    def _supported(self, support: Support) -> list[fem.DirichletBC]:
        field = f"supports.{support.name}.where"
        if support.keeps_slope and support.axes != "xyz":
            raise InputError(
                f"supports.{support.name}.axes = {support.axes!r}: the finite-element model keeps "
                "a slope only where x, y and z are held, expected kind = 'clamped' without axes"
            )
        nodes = nodes_of(support.part, self._planar, field)
        edges = edges_of(support.part, self._planar, field)
        surface = self._solid.mesh.volume.reference_surface
        at_surface = np.concatenate([np.column_stack([nodes, nodes]), edges])
        level = surface[at_surface]
        through = self._through(nodes, edges)
        if not support.keeps_slope:
            level = through = self._at_middle(through)
        return [
            self._solid.held_dofs(AXES[axis], level if axis == "z" else through)
            for axis in support.axes
        ]

    def _through(self, nodes: NDArray[np.int64], edges: Pairs) -> Pairs:
        """Return the places, as pairs of vertices, over nodes and edges, at every height."""
        volume = self._solid.mesh.volume
        under = volume.planar_nodes
        vertices = np.flatnonzero(np.isin(under, nodes))
        ends = np.concatenate([volume.cells[:, [i, j]] for i in range(4) for j in range(i)])
        ends = np.unique(np.sort(ends, axis=1), axis=0)
        low, high = np.sort(under[ends], axis=1).T
        count = len(self._planar.points)
        upright = (low == high) & np.isin(low, nodes)
        along = np.isin(low * count + high, np.sort(edges, axis=1) @ np.array([count, 1]))
        return np.concatenate([np.column_stack([vertices, vertices]), ends[upright | along]])

    def _at_middle(self, pairs: Pairs) -> Pairs:
        """Return those places that lie in the middle of the carrier."""
        volume, carrier = self._solid.mesh.volume, self._specimen.carrier
        layers = [layer.name for layer in self._specimen.layers if layer.name in self._layer_names]
        cells = volume.cells[volume.layer == layers.index(carrier.name)]
        heights = volume.points[cells, 2]
        middle = (heights.min() + heights.max()) / 2
        at = volume.points[pairs, 2].mean(axis=1)
        return pairs[np.abs(at - middle) < 1e-6 * carrier.thickness]

    @cached_property
    def _layer_names(self) -> set[str]:
        layers = self._specimen.layers
        return {layer.name for layer in layers if len(self._planar.faces_of(layer.name))}

    def _force(self, load: Load) -> list[NodalForce]:
        """Return a force at dofs along each axis."""
        pairs, weights = self._weights(load)
        if load.kind == "force":
            weights = weights / weights.sum()
        return [
            NodalForce(dofs.astype(np.int64), component * weights[which])
            for axis, component in enumerate(load.direction)
            if component
            for dofs, which in [self._solid.displacement_dofs(axis, pairs, owned=True)]
        ]

    def _weights(self, load: Load) -> tuple[Pairs, Array]:
        """Return places at the reference surface, and the length or area each one stands for."""
        planar, field = self._planar, _field(load)
        surface = self._solid.mesh.volume.reference_surface
        nodes = nodes_of(load.part, planar, field)
        is_line = load.part.on != "sheet" or bool(load.part.line)
        inside = planar.triangles[np.isin(planar.triangles, nodes).all(axis=1)]
        if load.part.point is not None or not (is_line or len(inside)):
            return surface[np.column_stack([nodes, nodes])], np.ones(len(nodes))
        if is_line:
            edges = edges_of(load.part, planar, field)
            lengths = np.linalg.norm(np.diff(planar.points[edges], axis=1)[:, 0], axis=1)
            ends = np.column_stack([edges.reshape(-1)] * 2)
            pairs = np.concatenate([ends, edges])
            shares = [SIMPSON[0] * np.repeat(lengths, 2), SIMPSON[1] * lengths]
            return surface[pairs], np.concatenate(shares)
        sides = inside[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        areas = planar.areas[np.isin(planar.triangles, nodes).all(axis=1)]
        return surface[sides], np.repeat(areas / 3, 3)

    def _grip(self, load: Load) -> _Grip:
        """Return the dofs of all nodes of a part and of the middles of its edges."""
        axis = int(np.argmax(np.abs(load.direction)))
        sign = float(load.direction[axis])
        if abs(sign) != 1.0:
            raise InputError(
                f"loads.{load.name}.direction = {list(load.direction)}: the finite-element model "
                "imposes displacements along an axis, expected 'x', 'y', 'z' or '-x', ..."
            )
        nodes = nodes_of(load.part, self._planar, _field(load))
        edges = edges_of(load.part, self._planar, _field(load))
        if load.part.point is not None:
            edges = edges[:0]
        surface = self._solid.mesh.volume.reference_surface
        pairs = surface[np.concatenate([np.column_stack([nodes, nodes]), edges])]
        dofs, _ = self._solid.displacement_dofs(axis, pairs, owned=True)
        layers = self._specimen.layers
        stiffness = sum(layer.material.young_modulus * layer.thickness for layer in layers)
        return _Grip(dofs.astype(np.int64), sign, stiffness)

    def _mean(self, grip: _Grip, state: State) -> float:
        """Return the mean displacement of what a grip holds, along its direction."""
        total = self._solid.nodal.total(grip.sign * state.values[grip.dofs])
        return total / self._solid.nodal.total(np.ones(len(grip.dofs)))

    def _body_response(self, load: Load, state: State) -> float:
        """Return the displacement along a body force, integrated over its natural volume."""
        return self._solid.total(self._body_forms[load.name], state)

    @cached_property
    def _body_forms(self) -> dict[str, fem.Form]:
        return {
            name: self._solid.natural_integral(ufl.dot(body.unit, self._solid.displacement))
            for name, body in self._bodies.items()
        }


def _names(specimen: Specimen, kind: str) -> list[str]:
    return [load.name for load in specimen.loads if load.kind == kind]


def _field(load: Load) -> str:
    return f"loads.{load.name}.where"
