"""Cauchy stress and elastic strain of all laws against closed forms."""

import numpy as np
import pytest
from verification.laws import LAW_CASES

from bilayer import InputError, LinearElastic
from bilayer.mechanics.layer_state import polar_rotation
from bilayer.mechanics.stress import cauchy_stress, green_strain

D1 = 2e-6
F = np.array([[1.12, 0.08, 0.02], [-0.05, 0.97, 0.04], [0.03, -0.02, 0.96]])


@pytest.mark.parametrize("name", LAW_CASES)
def test_the_cauchy_stress_is_that_of_the_closed_form(name):
    case = LAW_CASES[name]
    J = np.linalg.det(F)
    _, piola = case.first_piola(F, D1)
    rotation = polar_rotation(F)
    expected = rotation.T @ (piola @ F.T / J) @ rotation
    found = cauchy_stress(case.compressible(D1), F.T @ F, np.eye(3), np.array(2 * (J - 1) / D1))
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("name", LAW_CASES)
def test_a_sheet_in_plane_stress(name):
    stretch = 1.15
    C = np.diag([stretch**2, stretch**2, stretch**-4])
    found = cauchy_stress(LAW_CASES[name].law, C, np.eye(3), None)
    stress = LAW_CASES[name].equibiaxial_cauchy(stretch)
    assert found == pytest.approx(np.diag([stress, stress, 0.0]), abs=1e-8 * stress)


def test_the_linear_law_has_the_papers_initial_strain():
    """Bonded and flat: E eps / (1 - nu), the corrected eq. 8."""
    law, eps = LinearElastic(1e5, 0.3), 0.05
    prestretch = np.diag([1 + eps, 1 + eps, (1 + eps) ** -2])
    C = prestretch @ prestretch
    assert green_strain(law, C, prestretch)[0, 0] == pytest.approx(eps, rel=1e-12)
    stress = cauchy_stress(law, C, prestretch, None)
    assert np.diag(stress) == pytest.approx([1e5 * eps / 0.7, 1e5 * eps / 0.7, 0.0], rel=1e-12)


def test_the_linear_law_pushed_forward():
    """A bar of the bonded state: the second Piola stress E e becomes l^2 / J times that."""
    law, stretch = LinearElastic(1e5, 0.3), 1.1
    strain = (stretch**2 - 1) / 2
    across = np.sqrt(1 - 2 * 0.3 * strain)
    C = np.diag([stretch**2, across**2, across**2])
    stress = cauchy_stress(law, C, np.eye(3), None)
    expected = 1e5 * strain * stretch**2 / (stretch * across**2)
    assert np.diag(stress) == pytest.approx([expected, 0.0, 0.0], rel=1e-10, abs=1e-8)


def test_a_law_of_nobody():
    with pytest.raises(InputError, match="law = object"):
        cauchy_stress(object(), np.eye(3), np.eye(3), None)
