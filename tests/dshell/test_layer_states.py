"""The deformation of the shell's layers: uniform states, rotations, energies."""

import numpy as np
import pytest
from verification.laws import LAW_CASES
from verification.shell_fields import LAWS, STRETCH, shell_of, uniform_errors


@pytest.mark.parametrize("name", LAWS)
def test_strain_and_stress_of_a_uniform_state_are_those_of_the_energy(name):
    found = uniform_errors(LAWS[name])
    assert found.stress < 1e-8
    assert max(found.energy, found.strain) < 1e-10


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
