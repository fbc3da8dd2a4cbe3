"""The stretches at which laws lose their stability, against closed forms."""

import math

import numpy as np
import pytest
from made_results import cap_result, small_specimen
from scipy.optimize import brentq

from bilayer import ArrudaBoyce, Gent, LinearElastic, MooneyRivlin, NeoHookean, Ogden, Yeoh
from bilayer.results.report import describe_trust
from bilayer.specimen.materials import loss_of_stability, stability_limits, stability_warning
from bilayer.specimen.materials.stability import LOADINGS


@pytest.mark.parametrize("ratio", [1.0, 3.004, 4.723])
def test_equal_loads_on_mooney_rivlin(ratio):
    """Kearsley (1986): C01 / C10 = (1 + l^-6) / (l^2 - 3 l^-4)."""
    expected = brentq(lambda s: (1 + s**-6) - ratio * (s**2 - 3 * s**-4), 1.15, 3.0)
    limits = stability_limits(MooneyRivlin(1e4, ratio * 1e4))
    assert limits.equal_loads == pytest.approx(expected, rel=1e-9)
    assert all(map(math.isinf, limits.drucker.values()))


def test_the_papers_tape():
    assert stability_limits(MooneyRivlin(1.0, 3.004)).equal_loads == pytest.approx(1.263, abs=5e-4)


@pytest.mark.parametrize("loading", LOADINGS)
def test_drucker_of_mooney_rivlin_with_a_negative_constant(loading):
    """With G_i = C10 x_i + C01 / x_i, x_i = l_i^2: G1 G2 + G2 G3 + G3 G1 = 0."""
    law = MooneyRivlin(1e4, -2e3)

    def determinant(stretch):
        along, across = LOADINGS[loading](stretch)
        x = np.array([along, across, 1 / (along * across)]) ** 2
        a, b, c = law.c10 * x + law.c01 / x
        return a * b + b * c + c * a

    expected = brentq(determinant, 1.2, 3.0)
    assert stability_limits(law).drucker[loading] == pytest.approx(expected, rel=1e-9)


def test_drucker_of_yeoh_under_equal_stretches():
    """d/dl of t = 2 (l^2 - l^-4) w'(I1), I1 = 2 l^2 + l^-4, by hand."""
    law = Yeoh(1e4, -2e3, 100.0)

    def slope(s):
        x = 2 * s**2 + s**-4 - 3
        w, ww = law.c10 + 2 * law.c20 * x + 3 * law.c30 * x**2, 2 * law.c20 + 6 * law.c30 * x
        return (2 * s + 4 * s**-5) * w + (s**2 - s**-4) * ww * (4 * s - 4 * s**-5)

    found = stability_limits(law).drucker["equibiaxial"]
    assert found == pytest.approx(brentq(slope, 1.05, 1.5), rel=1e-9)


def test_ogden_with_the_exponents_of_mooney_rivlin_has_its_limit():
    one = stability_limits(Ogden([2.0, 6.008], [2.0, -2.0]))
    other = stability_limits(MooneyRivlin(1.0, 3.004))
    assert one.equal_loads == pytest.approx(other.equal_loads, rel=1e-10)


@pytest.mark.parametrize(
    "law",
    [NeoHookean(1e4), Gent(1e4, 5.0), ArrudaBoyce(1e4, 2.0), LinearElastic(1e5, 0.5)],
    ids=lambda law: law.name,
)
def test_laws_that_never_lose_it(law):
    limits = stability_limits(law)
    assert math.isinf(limits.equal_loads)
    assert all(map(math.isinf, limits.drucker.values()))


def test_which_criterion_fails_at_a_stretch():
    tape = MooneyRivlin(1.0, 3.004)
    assert loss_of_stability(tape, (1.26, 1.26)) == ""
    assert loss_of_stability(tape, (1.27, 1.27)) == "equal loads"
    assert loss_of_stability(tape, (1.27, 1.1)) == ""
    assert loss_of_stability(tape, (1.6, 1.5)) == "dead loads"
    assert loss_of_stability(MooneyRivlin(1e4, -2e3), (2.0, 2.0)) == "Drucker's criterion"
    assert loss_of_stability(LinearElastic(1e5, 0.5), (1.4, 1.4)) == ""
    assert loss_of_stability(Gent(1e4, 0.3), (1.1, 1.1)) == ""
    assert loss_of_stability(Gent(1e4, 0.3), (1.2, 1.2)) == "locking at constant volume"


def test_a_warning_names_layer_stretches_and_limit():
    tape = MooneyRivlin(1.0, 3.004)
    assert stability_warning("substrate", tape, [(1.2, 1.2), (1.26, 1.26)]) == ""
    assert stability_warning("substrate", tape, [(1.2, 1.2), (1.27, 1.27), (1.6, 1.5)]) == (
        "The law of the substrate is NOT STABLE at 1.27 by equal loads, from 1.263 on; at 1.6,1.5 "
        "by dead loads."
    )


def test_a_report_warns_of_what_is_beyond():
    beyond = small_specimen([1.26, 1.3])
    found = describe_trust(cap_result(beyond))
    assert "The law of the substrate is NOT STABLE at 1.3 by equal loads, from 1.263 on." in found
    assert "NOT STABLE" not in describe_trust(cap_result(beyond.with_milestones([1.26])))
