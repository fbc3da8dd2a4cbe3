"""A solid that relaxes: the energy of a step, relaxation and creep against closed forms."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.relaxing_solid import ONE_TERM, RelaxingBlock, exact_creep
from verification.relaxing_solid import TWO_TERMS as SERIES
from verification.solid_problem import newton_of

from bilayer import MooneyRivlin

STEPS = (0.1, 0.5, 7.0, 30.0, 300.0)


@pytest.fixture(scope="module")
def law():
    return MooneyRivlin(4839.1, 14536.0, 1e-6)


def test_a_stretch_that_is_held_relaxes_as_the_series_says(law):
    """Whatever the steps, also of a law that is compressible, at a stretch of 1.2."""
    found = RelaxingBlock(law, SERIES).held(1.2, STEPS)
    left = SERIES.stress_left(np.cumsum([0.0, *STEPS]))
    assert np.array(found) / found[0] == pytest.approx(left, rel=1e-6)
    assert left[-1] < 0.31


def test_creep_under_a_load_is_that_of_the_closed_form():
    """Extrapolated to steps of no length; the error of a step is of the second order."""
    law, end = MooneyRivlin(4839.1, 14536.0), 40.0
    coarse, fine = (RelaxingBlock(law, ONE_TERM).creep(end, count) for count in (20, 40))
    exact = exact_creep(np.linspace(0.0, end, 21), ONE_TERM)
    errors = [np.abs(found / exact - 1).max() for found in (coarse, fine[::2])]
    assert errors[0] < 3e-4 and 3.5 < errors[0] / errors[1] < 4.5
    assert (4 * fine[::2] - coarse) / 3 == pytest.approx(exact, rel=1e-6)


def test_the_energy_of_a_step_has_its_residual_and_tangent_as_derivatives(law):
    block = RelaxingBlock(law, SERIES)
    block.held(1.2, (0.5,))
    block.memory.aim_at(3.0, block.unstrained)
    solid, rng = block.solid, np.random.default_rng(4)
    state = solid.undeformed + 3e-5 * rng.normal(size=solid.undeformed.values.shape)
    along = 1e-6 * rng.normal(size=state.values.shape)

    def slope(function, h=1.0):
        return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)

    with newton_of(solid, []) as newton:
        power = newton.layout.dot(newton.residual(state), along)
        expected = slope(lambda step: solid.potential_energy(state + step * along))
        assert power == pytest.approx(expected, rel=1e-6)
        second = slope(lambda step: newton.residual(state + step * along))
        with newton.factorise(state) as factors, newton.layout.vectors(along, None) as (dx, image):
            factors.matrix.mult(dx, image)
            found = newton.layout.read(image)
        assert found == pytest.approx(second, rel=1e-5, abs=1e-6 * np.abs(second).max())
