"""Fields of the shell in states that are given: uniform and uneven. SI units."""

from dataclasses import dataclass

import numpy as np

from bilayer import LinearElastic, MeshSize, Prestretch, Specimen, generate_mesh
from bilayer.mechanics.dataset import isochoric
from bilayer.mechanics.stress import cauchy_stress, green_strain
from bilayer.specimen.layer import Layer, Response
from bilayer.specimen.outline import Rectangle
from dshell.materials.plane_stress import plane_stress_law
from dshell.models.morley import MorleyModel
from dshell.release.specimen_shell import SpecimenShell
from dshell.settings import MorleySettings
from verification.laws import LAW_CASES

STRETCH = (1.2, 1.1)
LAWS = {name: case.law for name, case in LAW_CASES.items()} | {"linear": LinearElastic(1e5, 0.4)}
LAWS |= {f"{name}, compressible": case.compressible(3e-6) for name, case in LAW_CASES.items()}
GRADIENT = np.array([[1.03, 0.04], [-0.02, 0.98]])


def shell_of(law) -> SpecimenShell:
    """Two layers of one law; the lower one is stretched and turned by 0.3 rad."""
    layers = (
        Layer("substrate", 1e-3, law, response=Response("path", angle=0.3)),
        Layer("kirigami", 5e-4, law),
    )
    specimen = Specimen(Rectangle(0.03, 0.02), layers, Prestretch((STRETCH,)), MeshSize(0.005))
    settings, mesh = MorleySettings(), generate_mesh(specimen)
    return SpecimenShell(specimen, mesh, lambda s, m: MorleyModel(s, m, settings), 1e-8)


@dataclass(frozen=True)
class UniformErrors:
    """Largest errors of principal stresses, over the largest, of energy density and strain."""

    stress: float
    energy: float
    strain: float


def uniform_errors(law) -> UniformErrors:
    """The flat sheet, stretched and sheared: stress from the law of the shell, pushed forward."""
    shell = shell_of(law)
    state = shell.flat(STRETCH).copy()
    nodes = shell.surface(state)
    nodes[:, :2] = nodes[:, :2] @ GRADIENT.T
    state[: nodes.size] = nodes.reshape(-1)
    found = {part.name: part for part in shell.layer_states(STRETCH, state)}
    strain = (GRADIENT.T @ GRADIENT - np.eye(2)) / 2
    told = np.array([strain[0, 0], strain[1, 1], 2 * strain[0, 1]])
    errors = []
    for layer in shell.specimen.bonded_layers(STRETCH):
        natural, part = np.array(layer.stretch), found[layer.name]
        plane = plane_stress_law(law).at(told[:, None], natural[:, :, None])
        xx, yy, xy = plane.stress()[:, 0]
        thickness = plane.thickness_stretch()[0] * np.linalg.det(natural)
        own = GRADIENT @ np.array([[xx, xy], [xy, yy]]) @ GRADIENT.T
        expected = np.zeros((3, 3))
        expected[:2, :2] = own / (np.linalg.det(GRADIENT) * thickness)
        stress = cauchy_stress(law, part.stretch, isochoric(layer), None)
        apart = np.linalg.eigvalsh(stress) - np.linalg.eigvalsh(expected)
        density = part.energy / (plane.energy()[0] * part.volume)
        errors.append(
            [
                np.abs(apart).max() / np.abs(expected).max(),
                np.abs(density - 1).max(),
                _strain_error(law, part, layer),
            ]
        )
    return UniformErrors(*(float(worst) for worst in np.max(errors, axis=0)))


def _strain_error(law, part, layer) -> float:
    """The largest error of the Green strain; 0 of the linear law, whose strain is another."""
    if isinstance(law, LinearElastic):
        return 0.0
    natural = np.array(layer.stretch)
    full = natural @ GRADIENT.T @ GRADIENT @ natural
    strain = green_strain(law, part.stretch, isochoric(layer))[..., :2, :2]
    return float(np.abs(strain - (full - np.eye(2)) / 2).max())


def energy_error() -> float:
    """Largest relative error of the sum of the energy density, in an uneven state."""
    shell = shell_of(LAW_CASES["mooney-rivlin"].law)
    rng, state = np.random.default_rng(1), shell.flat(STRETCH).copy()
    n = 3 * len(shell.mesh.points)
    state[:n] += 2e-5 * rng.normal(size=n)
    state[n : n + shell.model.extra_dofs] += 1e-5 * rng.normal(size=shell.model.extra_dofs)
    terms = shell.model.energy_terms(STRETCH, state)
    parts = shell.layer_states(STRETCH, state)
    return max(abs(float(part.energy.sum()) / terms[part.name] - 1) for part in parts)
