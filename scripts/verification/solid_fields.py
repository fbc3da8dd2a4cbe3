"""Fields of the finite-element model in states that are given: uniform, bent, uneven. SI units."""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI

from bilayer import Disc, MeshSize, NeoHookean, Prestretch, Specimen, generate_mesh
from bilayer.mechanics.dataset import isochoric
from bilayer.mechanics.stress import cauchy_stress, green_strain
from bilayer.specimen.layer import Layer, Response
from fenics_model.release.layer_states import layer_states
from fenics_model.release.specimen_solid import make_solid
from fenics_model.settings import SolidSettings

STRETCH = (1.2, 1.1)
LAW = NeoHookean(1e4, d1=1e-6)


def body_of(size=0.01, elements=1):
    """A disc of one law, its lower layer stretched; the upper one is cut from the top down."""
    stretched = Layer("substrate", 1e-3, LAW, response=Response("path"))
    layers = (stretched, Layer("kirigami", 5e-4, LAW))
    specimen = Specimen(Disc(0.02), layers, Prestretch((STRETCH,)), MeshSize(size))
    mesh = generate_mesh(specimen)
    settings = SolidSettings(substrate_elements=elements, kirigami_elements=elements)
    body = make_solid(specimen, mesh, settings, MPI.COMM_WORLD)
    body.prestretch(specimen, STRETCH)
    return body


@dataclass(frozen=True)
class UniformErrors:
    """Largest errors of the fields in a uniform state, of both layers.

    Those of strain and stretch are absolute, the others over the largest entry.
    """

    stretch: float
    strain: float
    stress: float
    pressure: float
    volume: float


def uniform_errors(elements: int) -> UniformErrors:
    """The bonded sheet, stretched, sheared and turned: the same strain and stress everywhere."""
    body = body_of(elements=elements)
    c, s = np.cos(0.4), np.sin(0.4)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    bonded = turn @ np.array([[1.03, 0.04, 0.0], [0.0, 0.98, 0.0], [0.0, 0.0, 0.99]])
    pressure = 321.0
    # one map of the whole body, which the two layers' thicknesses are scaled by alike
    state = body.solid.interpolate(
        lambda x: (bonded - np.eye(3)) @ x,
        *[lambda x: np.full(x.shape[1], pressure / float(body.solid.pressure_scale.value))] * 2,
    )
    found = []
    for part in layer_states(body, STRETCH, state):
        layer = body.specimen.bonded_layer(part.name, STRETCH)
        natural = np.eye(3)
        natural[:2, :2] = layer.stretch
        elastic = bonded @ natural  # drawn with its natural thickness
        C = elastic.T @ elastic
        strain = green_strain(LAW, part.stretch, isochoric(layer))
        J = np.linalg.det(elastic)
        B = elastic @ elastic.T / np.cbrt(J**2)
        expected = 2e4 / J * (B - np.trace(B) / 3 * np.eye(3)) + pressure * np.eye(3)
        stress = cauchy_stress(LAW, part.stretch, isochoric(layer), part.pressure)
        in_space = part.rotation @ stress @ np.swapaxes(part.rotation, -1, -2)
        area = body.mesh.areas[part.faces]
        volume = area * layer.layer.thickness / np.prod(np.diag(natural))
        errors = (
            part.stretch - C,
            strain - (C - np.eye(3)) / 2,
            (in_space - expected) / np.abs(expected).max(),
            part.pressure / pressure - 1,
            part.volume / volume - 1,
        )
        found.append([float(np.abs(error).max()) for error in errors])
    return UniformErrors(*np.max(found, axis=0))


def bent_stress_rate() -> float:
    """Power of the edge with which the stress's error falls in a sheet bent to a cylinder."""
    radius, errors, sizes = 0.05, [], []
    for size, elements in ((0.008, 1), (0.004, 2)):
        body = body_of(size, elements)

        def bend(x):
            angle, out = x[0] / radius, radius + x[2]
            return np.stack(
                [out * np.sin(angle) - x[0], 0 * x[0], out * np.cos(angle) - radius - x[2]]
            )

        part = layer_states(body, STRETCH, body.solid.interpolate(bend))[0]
        layer = body.specimen.bonded_layer(part.name, STRETCH)
        heights = np.array([-1.0, -0.5, 0.0]) * layer.layer.thickness
        exact = np.zeros(part.stretch.shape)
        natural = np.diag([STRETCH[0], STRETCH[1], 1.0])
        for level, z in enumerate(heights):
            own = np.diag([1 + z / radius, 1.0, 1.0]) @ natural
            exact[level] = own @ own
        stress, told = (
            cauchy_stress(LAW, C, isochoric(layer), part.pressure) for C in (part.stretch, exact)
        )
        errors.append(np.sqrt(np.mean((stress - told) ** 2)))
        sizes.append(np.sqrt(len(part.faces)))
    return float(np.log(errors[0] / errors[1]) / np.log(sizes[1] / sizes[0]))


def energy_error() -> float:
    """Largest relative error of the sum of the energy density, in an uneven state."""
    body = body_of(elements=2)
    wave = np.random.default_rng(2).normal(size=(3, 3)) * 0.05
    state = body.solid.interpolate(lambda x: wave @ x + 3.0 * np.stack([x[2], x[0], x[1]]) ** 2)
    parts = enumerate(layer_states(body, STRETCH, state))
    pairs = [(part.energy.sum(), body.solid.layer_energy(number, state)) for number, part in parts]
    return max(abs(found / told - 1) for found, told in pairs)
