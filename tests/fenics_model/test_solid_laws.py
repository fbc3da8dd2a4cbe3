"""Every hyperelastic law in the finite-element model: closed forms, patch test, the limit of Gent.

The derivatives and the invariances of the laws are among those of `test_solid`.
"""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification import solid_states
from verification.laws import LAW_CASES

from bilayer import Gent, MooneyRivlin, Ogden
from bilayer.errors import ComputationError

D1 = 1.03918061e-6  # 1/Pa


@pytest.fixture(scope="module", params=LAW_CASES.values(), ids=LAW_CASES)
def case(request):
    return request.param


@pytest.fixture(scope="module")
def block(case):
    """One solid for every state of a law, so that it is compiled once."""
    return solid_states.block(case.law)


@pytest.mark.parametrize("stretch", [1.06, 1.24])
def test_closed_forms(case, block, stretch):
    """Rung 24: uniaxial, equibiaxial and planar tension."""
    uniaxial = solid_states.uniaxial_stress(block, stretch)
    assert uniaxial == pytest.approx(case.uniaxial_nominal(stretch), rel=1e-6)
    equibiaxial = solid_states.equibiaxial_stress(block, stretch)
    assert equibiaxial == pytest.approx([case.equibiaxial_cauchy(stretch)] * 2, rel=1e-6)
    planar = solid_states.planar_stress(block, stretch)
    assert planar == pytest.approx(case.planar_nominal(stretch), rel=1e-6)


def test_compressible_patch(case):
    """Rung 2: a uniform deformation of the boundary of a distorted mesh is uniform inside."""
    patch = solid_states.compressible_patch(case.compressible(D1))
    energy, stress = case.first_piola(solid_states.PATCH_GRADIENT, D1)
    assert patch.energy_density == pytest.approx(energy, rel=1e-8)
    assert np.abs(patch.stress - stress).max() < 1e-8 * np.abs(stress).max()
    assert patch.unevenness < 1e-8


def test_ogden_with_the_exponents_of_mooney_rivlin_is_mooney_rivlin():
    law = MooneyRivlin(4839.1, 14_536.0)
    one = solid_states.block(Ogden([2 * law.c10, 2 * law.c01], [2, -2]))
    other = solid_states.block(law)
    for state in (solid_states.uniaxial_stress, solid_states.equibiaxial_stress):
        assert state(one, 1.24) == pytest.approx(state(other, 1.24), rel=1e-10)


def test_gent_has_no_state_beyond_its_limit():
    block = solid_states.block(Gent(38_750.0, 5.0))  # equibiaxial: locks at 1.99
    solid_states.equibiaxial_stress(block, 1.24)
    with pytest.raises(ComputationError, match="no homogeneous state"):
        solid_states.equibiaxial_stress(block, 2.05)
