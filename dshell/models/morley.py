"""The accurate model: Morley's shell with the layers and the natural state of a specimen."""

from collections.abc import Mapping, Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.bonding import check_no_gap
from bilayer.mesh.parts import clamped_edges
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.relaxation import ELASTIC
from bilayer.specimen.specimen import Specimen, refuse_fields
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.through_thickness import PROFILES, Laminate, ShellLayer
from dshell.materials.plane_stress import plane_stress_law
from dshell.models.layer_states import layer_states
from dshell.models.shares import share_on_faces
from dshell.models.wall_faces import WallFaces, walls_of
from dshell.models.wall_relief import wall_zones
from dshell.settings import MorleySettings

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]

WALL_WIDTH = 2.0
"""Distance of faces that share a wall, over the thickness of all layers."""
FACES_IN_A_BLOCK = 2048
"""Evaluated together, so that what is computed of them stays in the processor's cache."""


class MorleyModel:
    """A specimen on its planar mesh as Morley's shell; see `dshell.release.static.ShellModel`.

    Parameters
    ----------
    specimen, mesh
        What is released, on which planar mesh.
    settings : MorleySettings
        How strain varies through the thickness.

    Raises
    ------
    InputError
        A layer is cut away somewhere between two that lie there.
    """

    def __init__(self, specimen: Specimen, mesh: PlanarMesh, settings: MorleySettings) -> None:
        check_no_gap(specimen, mesh)
        self._specimen, self._mesh = specimen, mesh
        self._quadratic = PROFILES[settings.profile]
        clamped = clamped_edges(specimen, mesh)
        self._walls = FACES_AT_WALLS[settings.walls](specimen, mesh, clamped)
        faces = MorleyFaces(mesh.points, mesh.triangles, self._laminate((1.0, 1.0)), clamped)
        beyond = np.pad(faces.beyond, ((0, 0), (0, 1))).reshape(-1)
        self.extra_flat = np.concatenate([beyond, np.zeros(faces.edge_count)])
        self.extra_dofs, self.fold_count = len(self.extra_flat), faces.edge_count
        fixed = 3 * len(mesh.points) + np.arange(len(beyond))
        self.fixed_dofs = np.concatenate([fixed, faces.idle_dofs])
        starts = range(0, len(mesh.triangles), FACES_IN_A_BLOCK)
        blocks = [slice(start, start + FACES_IN_A_BLOCK) for start in starts]
        self._blocks = [(block, faces.part(block)) for block in blocks]

    def energies(self, stretch: tuple[float, float]) -> Sequence[MorleyFaces]:
        """Return the faces in blocks, the prestretch being (lambda_x, lambda_y)."""
        laminate = self._laminate(stretch)
        return [faces.with_laminate(laminate.part(block)) for block, faces in self._blocks]

    def reference_height(self, stretch: tuple[float, float]) -> float:
        """Return the height of the reference surface above the shell's own, flat, m.

        The shell's own surface is the mid-plane of the carrier, see `Specimen.carrier`; that of
        anything but a bilayer is the reference surface itself.
        """
        return -surface_height(self._specimen, stretch)

    def energy_terms(self, stretch: tuple[float, float], state: Array) -> Mapping[str, float]:
        """Return the energy of each layer, J."""
        parts = [faces.at(state).layer_energies() for faces in self.energies(stretch)]
        return {name: sum(part[name] for part in parts) for name in parts[0]}

    def layer_states(
        self, energies: Sequence[MorleyFaces], state: Array, turn: Array
    ) -> list[LayerState]:
        """See `dshell.release.specimen_shell.ShellModel`."""
        return layer_states([faces.at(state) for faces in energies], turn)

    def with_specimen(self, specimen: Specimen) -> "MorleyModel":
        """Return the model of another specimen on the same mesh."""
        model = copy(self)
        model._specimen = specimen
        return model

    def flat_gradient(self, stretch: tuple[float, float], state: Array) -> Array:
        """Return the derivative of the energy by the flat places of the nodes, N, (n, 2).

        The state stays, and so do the heights of the layers.

        Raises
        ------
        InputError
            Layers are relieved at walls, whose zones have no such derivative.
        """
        if self._walls:
            raise InputError(
                "solver.walls = 'relieved': has no derivative by the places of the nodes, which a "
                "design needs; expected 'strained'"
            )
        gradient = np.zeros((len(self._mesh.points), 2))
        for faces in self.energies(stretch):
            by_corners = faces.at(state).flat_gradient()
            np.add.at(gradient, faces.corners, by_corners.transpose(2, 1, 0))
        return gradient

    def _laminate(self, stretch: tuple[float, float]) -> Laminate:
        layers = specimen_layers(self._specimen, self._mesh, stretch)
        if not self._walls:
            return Laminate(layers, self._quadratic)
        zones = wall_zones(layers, self._walls, len(self._mesh.triangles))
        return Laminate(layers, self._quadratic, zones)


def _strained_walls(specimen: Specimen, mesh: PlanarMesh, clamped: Numbers) -> list[WallFaces]:
    """Return none: all layers are strained up to where they end."""
    return []


def _relieved_walls(specimen: Specimen, mesh: PlanarMesh, clamped: Numbers) -> list[WallFaces]:
    """Return the faces beside all walls that are not clamped; InputError if a layer relaxes."""
    refuse_fields(specimen, "zones beside walls, which end no such layer")
    for layer in specimen.layers:
        if layer.relaxation != ELASTIC:
            raise InputError(
                f"solver.walls = 'relieved': the layer {layer.name} relaxes, which zones beside "
                "walls do not; expected 'strained'"
            )
    width = WALL_WIDTH * sum(layer.thickness for layer in specimen.layers)
    return walls_of(mesh, width, clamped)


FACES_AT_WALLS = {"strained": _strained_walls, "relieved": _relieved_walls}
"""The faces where layers are relieved, by the name that a setting gives them."""


def specimen_layers(
    specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float]
) -> list[ShellLayer]:
    """Return the layers over the carrier's mid-plane in the flat bonded state, from the bottom.

    Parameters
    ----------
    specimen, mesh
        Thicknesses and materials; which triangles each layer covers.
    stretch : (float, float)
        (lambda_x, lambda_y) of the prestretch.
    """
    surface = surface_height(specimen, stretch)
    parts = [(part, mesh.faces_of(part.name)) for part in specimen.bonded_layers(stretch)]
    return [
        ShellLayer(
            part.name,
            plane_stress_law(part.layer.material),
            part.bottom - surface,
            part.top - surface,
            np.array(part.stretch),
            None if len(faces) == len(mesh.triangles) else faces,
            part.layer.relaxation,
            share=share_on_faces(part.layer.pattern, mesh, faces),
        )
        for part, faces in parts
        if len(faces)
    ]


def surface_height(specimen: Specimen, stretch: tuple[float, float]) -> float:
    """Return the height of the shell's surface above the reference surface, m.

    The shell's surface is the mid-plane of the carrier in the flat bonded state.
    """
    carrier = specimen.bonded_layer(specimen.carrier.name, stretch)
    return (carrier.bottom + carrier.top) / 2
