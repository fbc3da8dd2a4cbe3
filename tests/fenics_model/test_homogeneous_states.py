"""Homogeneous states with a closed form: rungs 1 and 2 of the verification ladder, prestresses."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.solid_problem import (
    held_where,
    mean,
    newton_of,
    rectangle,
    solid_of,
    stacked,
    stress,
)
from verification.solid_states import (
    SIDE,
    TAPE,
    THICKNESS,
    block,
    compressible_patch,
    equibiaxial_stress,
    solve_block,
    uniaxial_stress,
)

from bilayer import LinearElastic


@pytest.fixture(scope="module")
def tape_block():
    """One solid for every state of the incompressible tape, so that it is compiled once."""
    return block(TAPE)


@pytest.mark.parametrize(("stretch", "published"), [(1.06, 6307.92), (1.24, 19530.72)])
def test_uniaxial_nominal_stress(tape_block, stretch, published):
    nominal = uniaxial_stress(tape_block, stretch)
    exact = 2 * (stretch - stretch**-2) * (TAPE.c10 + TAPE.c01 / stretch)
    assert nominal == pytest.approx(exact, rel=1e-6)
    assert nominal == pytest.approx(published, abs=0.01)


@pytest.mark.parametrize(("stretch", "published"), [(1.06, 14037.14), (1.24, 60612.61)])
def test_equibiaxial_cauchy_stress(tape_block, stretch, published):
    along_x, along_y = equibiaxial_stress(tape_block, stretch)
    held = solve_block(tape_block, (stretch, stretch, 1.0), sides={0, 1})
    exact = 2 * (stretch**2 - stretch**-4) * (TAPE.c10 + TAPE.c01 * stretch**2)
    assert along_x == pytest.approx(exact, rel=1e-6)
    assert along_y == pytest.approx(published, abs=0.01)
    assert mean(tape_block, held, tape_block.gradient[2, 2]) == pytest.approx(stretch**-2, rel=1e-9)


def test_a_hanging_block_carries_its_weight():
    """Balance: the mean of P33 over a block hung at z = 0 is half the stress there, q h / 2."""
    weight = 3e4
    volume = stacked(rectangle(SIDE, SIDE, 2, 2), [THICKNESS])
    solid = solid_of(volume, [TAPE], body_force=-weight)
    top = [held_where(solid, axis, lambda x: np.isclose(x[2], 0)) for axis in range(3)]
    with newton_of(solid, top) as newton:
        outcome = newton.solve(solid.undeformed, 1e-13)
    assert outcome.converged
    assert mean(solid, outcome.state, stress(solid)[2, 2]) == pytest.approx(
        weight * THICKNESS / 2, rel=1e-8
    )


def test_compressible_patch():
    """A uniform deformation of the boundary of a distorted mesh is uniform inside."""
    patch = compressible_patch()
    assert patch.volume_ratio == pytest.approx(1.068152, rel=1e-8)
    assert patch.energy_density == pytest.approx(4912.431674, rel=1e-8)
    assert patch.unevenness < 1e-8
    found = patch.stress[[0, 0, 2], [0, 1, 2]]
    assert found == pytest.approx([132341.4487, 4765.5975, 137236.8145], rel=1e-8)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.5])
def test_prestress_of_the_linear_law(poisson_ratio):
    """Eq. 8 corrected: the bonded flat state has the stress E eps / (1 - nu), and none across."""
    material, strain = LinearElastic(116250.0, poisson_ratio), 0.08
    solid = block(material)
    state = solve_block(solid, (1 + strain, 1 + strain, 1.0), sides={0, 1})
    thinning = (1 + strain) ** -2
    assert mean(solid, state, solid.gradient[2, 2]) == pytest.approx(thinning, rel=1e-9)
    per_bonded_area = mean(solid, state, stress(solid)[0, 0]) / thinning
    assert per_bonded_area == pytest.approx(116250.0 * strain / (1 - poisson_ratio), rel=1e-9)
    assert abs(mean(solid, state, stress(solid)[2, 2])) < 1e-6
