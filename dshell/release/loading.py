"""The loads of a specimen on its shell: energies, dead forces, and what they do their work on."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.parts import check_pressed, edges_of, faces_of, node_shares
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.load import Load, Milestone
from bilayer.specimen.prestretch import UNSTRETCHED
from bilayer.specimen.specimen import Specimen
from dshell.energies.assembly import Energy, sum_at
from dshell.energies.grips import Grips
from dshell.energies.pressed_volume import PressedVolume
from dshell.energies.topology import sum_at_nodes

Array = NDArray[np.float64]


class AppliedLoad(Protocol):
    """A load on the shell."""

    def energies(self, value: float) -> Sequence[Energy]:
        """Return the energies that it adds at a value, always on the same stencils."""

    def forces(self, value: float) -> Array | float:
        """Return the dead force on each node at a value, N, (n, 3), or 0."""

    def response(self, value: float, state: Array) -> float:
        """Return what it does its work on; see `bilayer.specimen.load.RESPONSES`."""


@dataclass(frozen=True, eq=False)
class AppliedPressure:
    """A pressure on triangles."""

    triangles: NDArray[np.int64]

    def energies(self, value: float) -> Sequence[Energy]:
        """Return the work on the volume."""
        return [PressedVolume(self.triangles, value)]

    def forces(self, value: float) -> float:
        """Return 0."""
        return 0.0

    def response(self, value: float, state: Array) -> float:
        """Return the volume swept, m3."""
        return PressedVolume(self.triangles, value).volume(state)


@dataclass(frozen=True, eq=False)
class AppliedForce:
    """A dead force: so much on each node for a value of 1, along a direction."""

    places: Array
    shares: Array
    direction: Array

    def energies(self, value: float) -> Sequence[Energy]:
        """Return none."""
        return []

    def forces(self, value: float) -> Array:
        """Return the force on each node."""
        return value * np.multiply.outer(self.shares, self.direction)

    def response(self, value: float, state: Array) -> float:
        """Return the displacement along it, times its shares."""
        moved = state[: self.places.size].reshape(-1, 3) - self.places
        return float(self.shares @ moved @ self.direction)


@dataclass(frozen=True, eq=False)
class AppliedDisplacement:
    """A displacement that springs of a stiffness impose on nodes."""

    places: Array
    nodes: NDArray[np.int64]
    direction: Array
    stiffness: float

    def _grips(self, value: float) -> Grips:
        is_free = math.isnan(value)
        stiffness, displacement = (0.0, 0.0) if is_free else (self.stiffness, value)
        return Grips(self.places, self.nodes, self.direction, stiffness, displacement)

    def energies(self, value: float) -> Sequence[Energy]:
        """Return the springs."""
        return [self._grips(value)]

    def forces(self, value: float) -> float:
        """Return 0."""
        return 0.0

    def response(self, value: float, state: Array) -> float:
        """Return the force on the sheet, N."""
        return self._grips(value).force(state)


class ShellLoading:
    """All loads of a specimen on its shell.

    Parameters
    ----------
    specimen, mesh
        The loads, and what they act on.

    Raises
    ------
    InputError
        A load acts on no part of the mesh, or the edge of what a pressure acts on is not held.
    """

    def __init__(self, specimen: Specimen, mesh: PlanarMesh) -> None:
        self._specimen, self._mesh = specimen, mesh
        self._places = np.pad(mesh.points, ((0, 0), (0, 1)))
        check_pressed(specimen, mesh)

    @cached_property
    def _applied(self) -> list[AppliedLoad]:
        return [self._apply(load) for load in self._specimen.loads]

    def energies(self, milestone: Milestone) -> list[Energy]:
        """Return the energies of the loads at a milestone, always on the same stencils."""
        values = zip(self._applied, milestone[2:], strict=True)
        return [term for load, value in values for term in load.energies(value)]

    def forces(self, milestone: Milestone) -> Array:
        """Return the dead force on each node at a milestone, N, (n, 3)."""
        total = np.zeros_like(self._places)
        for load, value in zip(self._applied, milestone[2:], strict=True):
            total += load.forces(value)
        return total

    def responses(self, milestone: Milestone, state: Array) -> dict[str, float]:
        """Return what each load does its work on, by its name."""
        values = zip(self._specimen.loads, self._applied, milestone[2:], strict=True)
        return {load.name: applied.response(value, state) for load, applied, value in values}

    def _apply(self, load: Load) -> AppliedLoad:
        field, mesh = f"loads.{load.name}.where", self._mesh
        direction = np.array(load.direction)
        match load.kind:
            case "pressure":
                return AppliedPressure(mesh.triangles[faces_of(load.part, mesh, field)])
            case "displacement":
                nodes, _ = node_shares(load.part, mesh, field)
                return AppliedDisplacement(self._places, nodes, direction, self._stiffness)
            case "force":
                shares = self._shares_of_force(load, field)
            case "line_force":
                shares = self._lengths(load, field)
            case _:
                shares = self._volumes(load, field)
        return AppliedForce(self._places, shares, direction)

    def _shares_of_force(self, load: Load, field: str) -> Array:
        shares = np.zeros(len(self._places))
        nodes, of_nodes = node_shares(load.part, self._mesh, field)
        shares[nodes] = of_nodes
        return shares

    def _lengths(self, load: Load, field: str) -> Array:
        """Return the length of a line that each node stands for, m."""
        edges = edges_of(load.part, self._mesh, field)
        lengths = np.linalg.norm(np.diff(self._mesh.points[edges], axis=1)[:, 0], axis=1)
        return sum_at(edges, np.repeat(lengths / 2, 2), len(self._places))

    def _volumes(self, load: Load, field: str) -> Array:
        """Return the natural volume of a region that each node stands for, m3."""
        per_area = np.zeros(len(self._mesh.triangles))
        for layer in self._specimen.layers:
            per_area[self._mesh.faces_of(layer.name)] += layer.thickness
        chosen = np.zeros_like(per_area)
        faces = faces_of(load.part, self._mesh, field)
        chosen[faces] = per_area[faces] * self._mesh.areas[faces] / 3
        return sum_at_nodes(self._mesh.triangles, chosen)

    @property
    def _stiffness(self) -> float:
        """Of the springs that impose a displacement: that of the stretched sheet, N/m."""
        layers = self._specimen.layers
        return sum(layer.material.young_modulus * layer.thickness for layer in layers)


def unloaded(specimen: Specimen) -> Milestone:
    """Return the milestone without prestretch and load; a displacement is free there."""
    kinds = [load.kind for load in specimen.loads]
    return (*UNSTRETCHED, *(math.nan if kind == "displacement" else 0.0 for kind in kinds))
