"""The deformation of the shell's layers: uniform states, rotations, energies."""

import numpy as np
import pytest
from released_sheets import sheet_of
from verification.laws import LAW_CASES

from bilayer import LinearElastic, generate_mesh
from bilayer.mechanics.dataset import isochoric
from bilayer.mechanics.stress import cauchy_stress, green_strain
from bilayer.specimen.layer import Layer, Response
from bilayer.specimen.outline import Rectangle
from dshell.materials.plane_stress import plane_stress_law
from dshell.models.morley import MorleyModel
from dshell.release.specimen_shell import SpecimenShell
from dshell.settings import MorleySettings

STRETCH = (1.2, 1.1)


def shell_of(law):
    """Two layers of one law; the lower one is stretched and turned by 0.3 rad."""
    layers = (
        Layer("substrate", 1e-3, law, response=Response("path", angle=0.3)),
        Layer("kirigami", 5e-4, law),
    )
    specimen = sheet_of(Rectangle(0.03, 0.02), layers, (STRETCH,))
    mesh = generate_mesh(specimen)
    settings = MorleySettings()
    return SpecimenShell(specimen, mesh, lambda s, m: MorleyModel(s, m, settings), 1e-8)


LAWS = {name: case.law for name, case in LAW_CASES.items()} | {"linear": LinearElastic(1e5, 0.4)}
LAWS |= {f"{name}, compressible": case.compressible(3e-6) for name, case in LAW_CASES.items()}


@pytest.mark.parametrize("name", LAWS)
def test_strain_and_stress_of_a_uniform_state_are_those_of_the_energy(name):
    """The flat sheet, stretched and sheared: stress from the law of the shell, pushed forward."""
    shell, law = shell_of(LAWS[name]), LAWS[name]
    state = shell.flat(STRETCH)
    gradient = np.array([[1.03, 0.04], [-0.02, 0.98]])
    nodes = shell.surface(state)
    nodes[:, :2] = nodes[:, :2] @ gradient.T
    found = {part.name: part for part in shell.layer_states(STRETCH, nodes_state(shell, nodes))}
    strain = (gradient.T @ gradient - np.eye(2)) / 2
    told = np.array([strain[0, 0], strain[1, 1], 2 * strain[0, 1]])
    for layer in shell.specimen.bonded_layers(STRETCH):
        natural = np.array(layer.stretch)
        plane = plane_stress_law(law).at(told[:, None], natural[:, :, None])
        xx, yy, xy = plane.stress()[:, 0]
        piola = np.array([[xx, xy], [xy, yy]])  # second, of the flat bonded state
        state = found[layer.name]
        thickness = plane.thickness_stretch()[0] * np.linalg.det(natural)
        volume = np.linalg.det(gradient) * thickness
        expected = np.zeros((3, 3))
        expected[:2, :2] = gradient @ piola @ gradient.T / volume
        stress = cauchy_stress(law, state.stretch, isochoric(layer), None)
        turn = state.rotation
        in_space = turn @ stress @ np.swapaxes(turn, -1, -2)
        scale = np.abs(expected).max()
        values = np.linalg.eigvalsh(in_space)
        assert values == pytest.approx(
            np.broadcast_to(np.linalg.eigvalsh(expected), values.shape), abs=1e-8 * scale
        )
        if name != "linear":
            full = natural @ gradient.T @ gradient @ natural
            assert green_strain(law, state.stretch, isochoric(layer))[..., :2, :2] == pytest.approx(
                np.broadcast_to((full - np.eye(2)) / 2, (*state.stretch.shape[:2], 2, 2)), abs=1e-10
            )
        density = plane.energy()[0]
        assert state.energy == pytest.approx(density * state.volume, rel=1e-10)


def nodes_state(shell, nodes):
    state = shell.flat(STRETCH)
    state[: nodes.size] = nodes.reshape(-1)
    return state


def test_energies_add_up_and_rotations_follow_a_turn():
    shell = shell_of(LAW_CASES["mooney-rivlin"].law)
    rng = np.random.default_rng(1)
    state = shell.flat(STRETCH)
    n = 3 * len(shell.mesh.points)
    state[:n] += 2e-5 * rng.normal(size=n)
    state[n : n + shell.model.extra_dofs] += 1e-5 * rng.normal(size=shell.model.extra_dofs)
    parts = shell.layer_states(STRETCH, state)
    terms = shell.model.energy_terms(STRETCH, state)
    for part in parts:
        assert part.energy.sum() == pytest.approx(terms[part.name], rel=1e-12)
    whole = sum(part.volume.sum() for part in parts)
    assert whole == pytest.approx(0.03 * 0.02 * (1e-3 / (1.2 * 1.1) + 5e-4), rel=1e-12)
    for part in parts:
        turned = part.rotation @ np.swapaxes(part.rotation, -1, -2)
        assert turned == pytest.approx(np.broadcast_to(np.eye(3), turned.shape), abs=1e-12)
        assert np.linalg.det(part.rotation) == pytest.approx(1.0)


def test_an_upright_normal_of_the_rotation():
    shell = shell_of(LAW_CASES["mooney-rivlin"].law)
    for part in shell.layer_states(STRETCH, shell.flat(STRETCH)):
        assert part.rotation[..., 2] == pytest.approx(
            np.broadcast_to([0.0, 0, 1], part.rotation[..., 2].shape), abs=1e-12
        )


def test_bending_is_linear_through_the_thickness():
    """On a cylinder the strain along it varies from level to level by the same."""
    shell = shell_of(LAW_CASES["mooney-rivlin"].law)
    state = shell.flat(STRETCH)
    nodes = shell.surface(state).copy()
    nodes[:, 2] = -0.5 * 10.0 * nodes[:, 0] ** 2
    lower, _ = shell.layer_states(STRETCH, nodes_state(shell, nodes))
    strain = (lower.stretch[..., 0, 0] - 1) / 2
    steps = np.diff(strain, axis=0)
    assert steps[0] == pytest.approx(steps[1], rel=1e-2)  # but for what is bent across
    assert np.median(steps[0]) == pytest.approx(10.0 * 0.5e-3, rel=0.2)  # curvature times rise
