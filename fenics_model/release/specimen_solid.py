"""The solid of a specimen: its layers extruded, with natural states, loads and held points."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from numpy.typing import NDArray

from bilayer.geometry.saddle_load import SaddleLoad
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.layer import Layer, Tensor
from bilayer.specimen.load import LOAD_KINDS
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.support import HeldNodes
from fenics_model.mesh.layered_mesh import LayeredMesh
from fenics_model.mesh.volume_mesh import Slab, VolumeMesh, extrude
from fenics_model.path.load_schedule import LoadPlace
from fenics_model.release.bonded_state import bonded_volume_and_pressure
from fenics_model.release.loading import SolidLoading, body_load, skin_pressure
from fenics_model.settings import SolidSettings, elements_through
from fenics_model.solid.memory import PRESSURE, DeadStresses, SolidMemory
from fenics_model.solid.solid import Solid, SolidLayer
from fenics_model.solid.state import State
from fenics_model.solid.strain_energy import (
    NOTHING,
    Remembered,
    StrainEnergy,
    energy_constants,
    natural_determinant,
    natural_tensor,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SpecimenSolid:
    """A specimen as a solid, and what of it can change.

    Parameters
    ----------
    solid : Solid
        The layers, from the bottom up.
    specimen : Specimen
        Whose layers they are.
    mesh : PlanarMesh
        The planar mesh that is extruded.
    settings : SolidSettings
        How it is discretised.
    layer_names : tuple of str
        Of the layers, in the same order.
    densities : tuple of dolfinx Constant
        Of the layers, kg/m3.
    weight, saddle : dolfinx Constant
        The accelerations that act now.
    loading : SolidLoading
        Supports and loads.
    memory : SolidMemory or None
        What layers remember; None: the specimen has no milestones of time.
    """

    solid: Solid
    specimen: Specimen
    mesh: PlanarMesh
    settings: SolidSettings
    layer_names: tuple[str, ...]
    densities: tuple[fem.Constant, ...]
    weight: fem.Constant
    saddle: fem.Constant
    loading: SolidLoading
    memory: SolidMemory | None = None

    def load(self, place: LoadPlace) -> None:
        """Set natural states and loads for a place on the load path."""
        self.prestretch(self.specimen, place.stretch)
        self.weight.value = self.specimen.gravity * place.weight
        self.saddle.value = self.settings.imperfection * place.imperfection
        self.loading.act(place)
        if self.memory is not None:
            self.memory.aim_at(place.time, partial(self._held_stress, stretch=place.stretch))

    def remember(self, place: LoadPlace, state: State) -> None:
        """Keep what the layers remember in the equilibrium at a place, the end of a step."""
        if self.memory is not None:
            self.load(place)
            self.memory.arrive(state, partial(self._held_stress, stretch=place.stretch))

    def _held_stress(self, number: int, stretch: StretchPair) -> Array:
        """Return the instantaneous stresses of a layer that is held stretched; see `Held`."""
        assert self.memory is not None
        name = self.layer_names[number]
        bonded = self.specimen.bonded_layer(name, stretch)
        volume, pressure = bonded_volume_and_pressure(self.specimen.layer(name), bonded.stretch)
        thinning = volume / natural_determinant(self.solid.layers[number].natural.value)
        flat = self.solid.interpolate(
            lambda x: np.stack([0 * x[0], 0 * x[0], (thinning - 1) * x[2]])
        )
        found = self.memory.uniform_stress(number, flat)
        found[PRESSURE] = pressure
        return found

    def prestretch(self, specimen: Specimen, stretch: StretchPair) -> None:
        """Set the natural states alone, those of a specimen."""
        rule = specimen.prestretch.thickness
        for name, layer in zip(self.layer_names, self.solid.layers, strict=True):
            bonded = specimen.bonded_layer(name, stretch)
            layer.natural.value = natural_state(bonded.stretch, rule)

    @contextmanager
    def use_specimen(self, specimen: Specimen, place: LoadPlace) -> Iterator[None]:
        """Be another specimen of the same mesh meanwhile, then what it was before."""
        constants = list(self._constants())
        before = [constant.value.copy() for constant in constants]
        try:
            self._take_constants(specimen, place)
            with self.solid.mesh.drawn_at(self._drawn(specimen).points):
                yield
        finally:
            for constant, value in zip(constants, before, strict=True):
                constant.value = value

    def _constants(self) -> Iterator[fem.Constant]:
        yield from (self.weight, *self.densities)
        for layer in self.solid.layers:
            yield layer.natural
            yield from layer.energy.symbols.values()

    def _take_constants(self, specimen: Specimen, place: LoadPlace) -> None:
        """Set natural states, weight, densities and laws to those of a specimen."""
        self.prestretch(specimen, place.stretch)
        self.weight.value = specimen.gravity * place.weight
        layers = layers_on(specimen, self.mesh)
        for own, density, layer in zip(layers, self.densities, self.solid.layers, strict=True):
            density.value = own.density
            set_law(layer.energy, own)

    def _drawn(self, specimen: Specimen) -> VolumeMesh:
        return extrude_layers(specimen, self.mesh, self.settings)


def asymmetric_lift(body: SpecimenSolid) -> NDArray[np.float64]:
    """Return a lift of the body that has part in every low mode: the sum of cos(n (t - n)).

    Each (r/R)^n cos(n (t - n)), n = 2 ... 6, is a harmonic polynomial of the place, so it is smooth
    at the centre and the same however the mesh is distributed; the phases n are in no symmetry.
    It tells the two sides of a mode apart. R is the sheet's characteristic length.

    Parameters
    ----------
    body : SpecimenSolid
        To be lifted, about its centre.

    Returns
    -------
    array of float
        A change of the state, this rank's dofs.
    """
    x0, y0 = body.mesh.centroid

    def lift(x: NDArray[np.float64]) -> NDArray[np.float64]:
        place = (x[0] - x0 + 1j * (x[1] - y0)) / body.specimen.characteristic_length
        waves = sum((place**n * np.exp(-1j * n * n)).real for n in range(2, 7))
        return np.stack([0 * x[0], 0 * x[0], waves])

    return body.solid.interpolate(lift).values


def natural_state(stretch: Tensor, thickness_rule: str) -> tuple[float, float, float, float]:
    """Return (Uxx, Uxy, Uyy, s) of a layer, see `strain_energy.natural_tensor`.

    Drawn with its natural thickness ("natural"), the mesh is stretched in plane alone, s = 1. Drawn
    with its bonded thickness ("constant"), it also has the thinning, s = 1 / det U.
    """
    (x, shear), (_, y) = stretch
    thinning = 1.0 if thickness_rule == "natural" else 1 / (x * y - shear * shear)
    return x, shear, y, thinning


def make_solid(
    specimen: Specimen, mesh: PlanarMesh, settings: SolidSettings, comm: MPI.Comm
) -> SpecimenSolid:
    """Build the solid of a specimen on a planar mesh.

    Both ways of drawing a stretched layer have the `thickness` of the specimen's `Layer`: it is the
    natural thickness by one rule and the bonded one by the other.
    """
    layers = layers_on(specimen, mesh)
    layered = LayeredMesh(extrude_layers(specimen, mesh, settings), comm)
    relaxing = relaxing_layers(specimen, layers)
    dead = DeadStresses(layered, settings.quadrature_degree) if relaxing else None
    weight, saddle = _constant(layered, 0.0), _constant(layered, 0.0)
    densities = tuple(_constant(layered, layer.density) for layer in layers)
    of_kind = {kind: [ld for ld in specimen.loads if ld.kind == kind] for kind in LOAD_KINDS}
    bodies = [body_load(load, layered, mesh) for load in of_kind["body_force"]]
    pressures = [skin_pressure(load, layered, mesh) for load in of_kind["pressure"]]
    parts = []
    for number, (layer, density) in enumerate(zip(layers, densities, strict=True)):
        acceleration = -weight + saddle * _saddle_shape(layered, saddle_on(layer, specimen, mesh))
        forces = [body.vector for body in bodies]
        remembered = dead.of_layer() if dead is not None and number in relaxing else NOTHING
        parts.append(_solid_layer(layered, layer, density * acceleration, forces, remembered))
    solid = Solid(
        layered,
        parts,
        skin_pressures=pressures,
        pressure_scale=specimen.carrier.material.shear_modulus / specimen.carrier.thickness,
        quadrature_degree=settings.quadrature_degree,
    )
    names = tuple(layer.name for layer in layers)
    loading = SolidLoading(solid, specimen, mesh, bodies, pressures)
    hold = 0.0 if specimen.schedule is None else specimen.schedule.hold
    memory = None if dead is None else SolidMemory(solid, dead, relaxing, hold)
    return SpecimenSolid(
        solid, specimen, mesh, settings, names, densities, weight, saddle, loading, memory
    )


def relaxing_layers(specimen: Specimen, layers: Sequence[Layer]) -> dict[int, PronySeries]:
    """Return the series of the layers that relax on the path, by their numbers."""
    series = {number: layer.relaxation for number, layer in enumerate(layers)}
    is_timed = specimen.schedule is not None
    return {number: given for number, given in series.items() if is_timed and given.terms}


def layers_on(specimen: Specimen, mesh: PlanarMesh) -> list[Layer]:
    """Return the layers that a planar mesh has any triangles of, from the bottom up."""
    return [layer for layer in specimen.layers if len(mesh.faces_of(layer.name))]


def extrude_layers(specimen: Specimen, mesh: PlanarMesh, settings: SolidSettings) -> VolumeMesh:
    """Extrude the planar mesh, each layer where it lies, the reference surface at z = 0."""
    layers = layers_on(specimen, mesh)
    slabs = [
        Slab(
            layer.thickness,
            elements_through(layer.name, specimen, settings),
            mesh.triangles[mesh.faces_of(layer.name)],
        )
        for layer in layers
    ]
    return extrude(mesh, slabs, below=_layers_below(specimen, layers))


def _layers_below(specimen: Specimen, layers: Sequence[Layer]) -> float:
    """Return the number of layers, and the part of one, below the reference surface."""
    surface, names = specimen.reference_surface, specimen.layer_names
    number = names.index(surface.layer)
    below = sum(names.index(layer.name) < number for layer in layers)
    is_there = any(layer.name == surface.layer for layer in layers)
    return below + surface.share if is_there else below


def saddle_on(layer: Layer, specimen: Specimen, mesh: PlanarMesh) -> SaddleLoad:
    """Return the saddle-shaped load that is in balance on a layer, whatever its mass."""
    triangles = mesh.triangles[mesh.faces_of(layer.name)]
    return SaddleLoad.on_plate(mesh.points, triangles, specimen.characteristic_length)


def held_points(nodes: HeldNodes, volume: VolumeMesh) -> list[tuple[int, int]]:
    """Return the six vertex components at the reference surface that are held, by planar nodes."""
    a, b, c = volume.reference_surface[list(nodes)]
    return [(a, 0), (a, 1), (a, 2), (b, 1), (b, 2), (c, 2)]


def _solid_layer(
    mesh: LayeredMesh,
    layer: Layer,
    weight_density: Any,
    forces: Sequence[Any],
    memory: Remembered,
) -> SolidLayer:
    """Return a layer under dead forces per natural volume, N/m3: one along z, and vectors."""
    natural = _constant(mesh, (1.0, 0.0, 1.0, 1.0))
    # det G volumes of mesh hold one natural volume, which is what the density is for
    per_volume = ufl.det(natural_tensor(natural))
    total = ufl.as_vector((0, 0, weight_density / per_volume))
    for force in forces:
        total += force / per_volume
    return SolidLayer(strain_energy(mesh, layer), natural, total, memory)


def strain_energy(mesh: LayeredMesh, layer: Layer) -> StrainEnergy:
    """Return the energy of a layer, its constants free to change without compiling anew."""
    kind, values = energy_constants(layer.material)
    energy: StrainEnergy = kind(**{name: _constant(mesh, v) for name, v in values.items()})
    return energy


def set_law(energy: StrainEnergy, layer: Layer) -> None:
    """Give an energy made by `strain_energy` the constants of a layer's law."""
    _, values = energy_constants(layer.material)
    for name, value in values.items():
        energy.symbols[name].value = value


def _constant(mesh: LayeredMesh, value: float | tuple[float, ...]) -> fem.Constant:
    return fem.Constant(mesh.mesh, np.asarray(value, dtype=default_scalar_type))


def _saddle_shape(mesh: LayeredMesh, load: SaddleLoad) -> Any:
    """Return the acceleration of a load, over its size, its numbers free of the compiled forms."""
    x, y, _ = ufl.SpatialCoordinate(mesh.mesh)
    a, b, c = load.affine
    free = SaddleLoad(_constant(mesh, load.length), _constant(mesh, (a, b, c)))
    return free.at(x, y)
