"""Constants and moduli of the laws."""

import math

import pytest

from bilayer import InputError, LinearElastic, MooneyRivlin, NeoHookean


def test_moduli_of_the_papers_substrate():
    """The constants that the template's moduli stand for, as published beside the template."""
    law = MooneyRivlin.from_moduli(116_250.0, 0.49, 3.004)
    assert law.c10 == pytest.approx(4871.4, abs=0.05)
    assert law.c01 == pytest.approx(14_633.7, abs=0.06)
    assert law.d1 == pytest.approx(1.03226e-6, rel=1e-5)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.5])
def test_moduli_come_back(nu):
    law = MooneyRivlin.from_moduli(2e5, nu, 0.7)
    assert law.poisson_ratio == pytest.approx(nu, abs=1e-12)
    assert law.young_modulus == pytest.approx(2e5, rel=1e-12)
    assert law.shear_modulus == pytest.approx(2e5 / (2 * (1 + nu)), rel=1e-12)
    assert law.c01 / law.c10 == pytest.approx(0.7, rel=1e-12)


def test_incompressible_is_d1_of_zero():
    law = MooneyRivlin.from_moduli(1e5, 0.5)
    assert law.d1 == 0
    assert math.isinf(law.bulk_modulus)
    assert MooneyRivlin(4839.1, 14_536.0).young_modulus == pytest.approx(116_250, rel=1e-5)


def test_neo_hookean_has_no_second_invariant():
    assert NeoHookean.from_moduli(1e5, 0.4).c01 == 0
    with pytest.raises(InputError, match="c01 = 5"):
        NeoHookean(c10=1.0, c01=5.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: MooneyRivlin(-2.0, 1.0), r"c10 \+ c01 = -1.0 Pa"),
        (lambda: MooneyRivlin(math.nan, 1.0), "c10 = nan"),
        (lambda: MooneyRivlin(1.0, 1.0, -1e-9), "d1 = -1e-09 1/Pa"),
        (lambda: MooneyRivlin(1.0, 1.0, 1.0), "d1 = 1.0 1/Pa: expected at most 0.75"),
        (lambda: MooneyRivlin.from_moduli(0.0, 0.3), "young_modulus = 0.0 Pa"),
        (lambda: MooneyRivlin.from_moduli(1.0, 0.51), "poisson_ratio = 0.51: expected from 0 to"),
        (lambda: LinearElastic(1.0, -0.1), "poisson_ratio = -0.1"),
    ],
)
def test_bad_constants_are_named(make, message):
    with pytest.raises(InputError, match=message):
        make()
