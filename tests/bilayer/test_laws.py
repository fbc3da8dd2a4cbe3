"""The laws as data: constants, moduli, energy with its derivatives, tables of a file."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from verification.laws import LAW_CASES

from bilayer import (
    ArrudaBoyce,
    Gent,
    Hyperelastic,
    InputError,
    LinearElastic,
    MooneyRivlin,
    NeoHookean,
    Ogden,
    Yeoh,
    register_law,
)
from bilayer.specimen.materials import LAWS, law_from_table, law_keys, law_to_table
from bilayer.specimen.materials.jet import Jet, JetFunctions
from bilayer.specimen.materials.power_sum import ACCURACY, LARGEST_STRETCH, power_sum


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
        (lambda: Yeoh(-1.0, 2.0, 3.0), "'yeoh': the constants make a shear modulus of -2 Pa"),
        (lambda: Yeoh(1.0, math.inf, 3.0), "c20 = inf: expected a finite number"),
        (lambda: Gent(1e4, 0.0), "jm = 0.0: expected a number greater than 0"),
        (lambda: Gent(1e4, 5.0, 1.0), "d1 = 1.0 1/Pa: expected at most 0.0003 1/Pa"),
        (lambda: ArrudaBoyce(1e4, -2.0), "lambda_m = -2.0: expected a number greater than 0"),
        (lambda: Ogden([1e4, 2e4], [2.0]), "mu has 2 terms, alpha 1: expected one exponent for"),
        (lambda: Ogden([1.0] * 4, [2.0] * 4), r"mu = \[1.0, 1.0, 1.0, 1.0\]: expected from 1 to 3"),
        (lambda: Ogden([], []), r"mu = \[\]: expected from 1 to 3 numbers"),
        (lambda: Ogden("soft", [2.0]), "mu = 'soft': expected a list of numbers"),
        (lambda: Ogden([1.0, "soft"], [2.0, 1.0]), "mu = 'soft': expected a number"),
        (lambda: Ogden([1e4], [0.0]), "alpha = 0.0: expected from 0.1 to 20"),
        (lambda: Ogden([1e4, -3e4], [2.0, -2.0]), "shear modulus of -20000 Pa, expected more"),
    ],
)
def test_bad_constants_are_named(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_numbers_are_kept_as_pythons_own():
    law = MooneyRivlin(np.float64(4839.1), np.int64(14536), np.float32(0))
    assert [type(value) for value in vars(law).values()] == [float, float, float]
    assert Ogden(np.array([1e4, 2e4]), (2, -2)).mu == (1e4, 2e4)
    assert Ogden(1e4, 2.0) == Ogden([1e4], [2.0])


HYPERELASTIC = {name: case.law for name, case in LAW_CASES.items()}


@pytest.fixture(params=HYPERELASTIC.values(), ids=HYPERELASTIC)
def law(request):
    return request.param


def random_invariants(size=50):
    """I1 and I2 of stretches up to 1.5 at constant volume."""
    x, y = np.random.default_rng(2).uniform(1 / 1.5, 1.5, (2, size)) ** 2
    z = 1 / (x * y)
    return x + y + z, 1 / x + 1 / y + 1 / z


def test_energy_is_the_closed_form_of_the_principal_stretches(law):
    case = LAW_CASES[law.name]
    for x, y in np.random.default_rng(3).uniform(0.7, 1.5, (20, 2)):
        stretches = np.array([x, y, 1 / (x * y)])
        I1, I2 = (stretches**2).sum(), (stretches**-2.0).sum()
        expected = case.energy(stretches)
        assert law.energy(I1, I2, np) == pytest.approx(expected, rel=1e-9, abs=1e-7)


def test_natural_state_has_no_energy(law):
    assert law.energy(3.0, 3.0, np) == pytest.approx(0.0, abs=1e-9 * law.shear_modulus)


def test_slopes_are_the_derivatives_of_the_energy(law):
    I1, I2 = random_invariants()
    step = 1e-3
    at = law.slopes(I1, I2)

    def differences(function):
        def slope(a, b):
            near = function(I1 + a, I2 + b) - function(I1 - a, I2 - b)
            far = function(I1 + 2 * a, I2 + 2 * b) - function(I1 - 2 * a, I2 - 2 * b)
            return (8 * near - far) / (12 * step)

        return slope(step, 0.0), slope(0.0, step)

    def first(k):
        return lambda a, b: law.slopes(a, b).first[k] + 0 * a

    scale = law.shear_modulus
    assert at.value == pytest.approx(law.energy(I1, I2, np), rel=1e-12)
    found = differences(lambda a, b: law.energy(a, b, np))
    xx, xy = differences(first(0))
    yx, yy = differences(first(1))
    for own, expected in zip(
        (*at.first, *at.second, at.second[1]), (*found, xx, xy, yy, yx), strict=True
    ):
        assert np.abs(own - expected).max() < 1e-7 * scale


def test_mooney_rivlin_alone_has_the_same_slopes_everywhere(law):
    I1, I2 = random_invariants()
    assert law.slopes(I1, I2).is_linear == isinstance(law, MooneyRivlin)


@pytest.mark.parametrize(
    ("law", "shear_modulus"),
    [
        (Yeoh(1e4, -3e3, 2e3), 2e4),
        (Gent(3e4, 7.0), 3e4),
        (
            ArrudaBoyce(3e4, 2.0),
            3e4 * (1 + 3 / 20 + 99 / 2800 + 513 / 56_000 + 42_039 / (67_375 * 256)),
        ),
        (Ogden([1e4, 5e3, 2e3], [2.0, -4.0, 8.0]), 1.7e4),
        (Ogden([1e4, 5e3, 2e3], [1.3, -0.7, 5.5]), 1.7e4),
    ],
    ids=lambda value: getattr(value, "name", ""),
)
def test_small_strain_shear_modulus(law, shear_modulus):
    assert law.shear_modulus == pytest.approx(shear_modulus, rel=1e-9)
    assert law.young_modulus == pytest.approx(3 * shear_modulus, rel=1e-9)
    assert law.poisson_ratio == 0.5


@pytest.mark.parametrize(
    "law",
    [
        Yeoh.from_moduli(2e5, 0.45, 0.1, -0.02),
        Gent.from_moduli(2e5, 0.45, 20.0),
        ArrudaBoyce.from_moduli(2e5, 0.45, 3.0),
    ],
    ids=lambda law: law.name,
)
def test_moduli_of_the_new_laws_come_back(law):
    assert law.young_modulus == pytest.approx(2e5, rel=1e-12)
    assert law.poisson_ratio == pytest.approx(0.45, rel=1e-12)


def test_gent_locks():
    law = Gent(3e4, 5.0)
    with np.errstate(invalid="ignore"):
        beyond = law.slopes(np.array([8.1]), np.array([8.1]))
    numbers = [beyond.value, beyond.first[0], beyond.second[0]]
    assert not np.isfinite(np.concatenate(numbers)).any()
    assert np.isfinite(law.energy(7.9, 7.9, np))


exponents = st.floats(0.1, 20).flatmap(lambda size: st.sampled_from([size, -size]))
stretch = st.floats(1 / 1.8, 1.8)


@given(exponents, stretch, stretch)
def test_power_sum(exponent, x, y):
    stretches = np.array([x, y, 1 / (x * y)])
    found = power_sum(exponent, (stretches**2).sum(), (stretches**-2.0).sum())
    assert found == pytest.approx((stretches**exponent).sum(), rel=1e-10)


@pytest.mark.parametrize("exponent", [0.1, 1.0, 1.9999999, 2.0000001, 3.7, -0.5, -1.0, 7.3])
def test_power_sum_over_the_whole_range(exponent):
    x = np.geomspace(LARGEST_STRETCH**-0.5, LARGEST_STRETCH**0.5, 60)[:, None]
    stretches = np.stack(np.broadcast_arrays(x, x.T, 1 / (x * x.T)))
    I1, I2 = (stretches**2).sum(axis=0), (stretches**-2.0).sum(axis=0)
    error = power_sum(exponent, I1, I2) / (stretches**exponent).sum(axis=0) - 1
    assert np.abs(error).max() < 10 * ACCURACY


def test_ogden_with_the_exponents_of_mooney_rivlin_is_mooney_rivlin():
    I1, I2 = random_invariants()
    ogden, mooney = Ogden([9678.2, 29_072.0], [2.0, -2.0]), MooneyRivlin(4839.1, 14_536.0)
    one, other = ogden.slopes(I1, I2), mooney.slopes(I1, I2)
    assert one.value == pytest.approx(other.value, rel=1e-12)
    assert one.first == pytest.approx(other.first, rel=1e-12)
    assert one.is_linear


def test_jets_follow_the_rules_of_differentiation():
    x, y = Jet.variables(0.7, 1.9)
    f = JetFunctions(np)
    found = f.exp(x * y) / f.sqrt(y) - (2 - x) ** 3 * f.log(y) + 1 / x
    e, r, log = math.exp(0.7 * 1.9), 1.9**-0.5, math.log(1.9)
    assert found.value == pytest.approx(e * r - 1.3**3 * log + 1 / 0.7)
    assert found.first == pytest.approx(
        [
            1.9 * e * r + 3 * 1.3**2 * log - 0.7**-2,
            e * r * (0.7 - 0.5 / 1.9) - 1.3**3 / 1.9,
        ]
    )
    assert found.second == pytest.approx(
        [
            1.9**2 * e * r - 6 * 1.3 * log + 2 * 0.7**-3,
            e * r * (1 + 1.9 * (0.7 - 0.5 / 1.9)) + 3 * 1.3**2 / 1.9,
            e * r * ((0.7 - 0.5 / 1.9) ** 2 + 0.5 / 1.9**2) + 1.3**3 / 1.9**2,
        ]
    )


@pytest.mark.parametrize("law", [*HYPERELASTIC.values(), LinearElastic(1e5, 0.3)])
def test_a_table_reads_back_the_same_law(law):
    assert law_from_table(law_to_table(law), "substrate") == law


def test_a_law_is_given_by_constants_or_by_moduli():
    given = {"law": "gent", "young_modulus": 1e5, "poisson_ratio": 0.5, "jm": 9}
    assert law_from_table(given, "kirigami") == Gent.from_moduli(1e5, 0.5, 9)
    assert law_to_table(Ogden([1, 2.5], [2, -2])) == {
        "law": "ogden", "mu": [1, 2.5], "alpha": [2, -2], "d1": 0.0,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"law": "gentle"}, "substrate.law = 'gentle': expected .*; did you mean 'gent'"),
        ({"law": "gent", "c10": 1.0}, "substrate.c10: not a constant of law = 'gent', expected y"),
        ({"law": "gent", "jm": 1.0}, "substrate.young_modulus: missing, expected young_modulus a"),
        ({"law": "gent", "mu": 1.0, "jm": 1.0}, "substrate.d1: missing, expected mu and jm and d1"),
        ({"law": "gent", "young_modulus": 1.0, "poisson_ratio": 0.5}, "substrate.jm: missing"),
        ({"law": "gent", "mu": 1.0, "young_modulus": 1.0}, "substrate.mu: given together with y"),
        ({"law": "ogden", "mu": 1.0, "alpha": 2.0}, "substrate.d1: missing, expected mu and alph"),
        ({"law": "yeoh", "c10": "soft", "c20": 0, "c30": 0, "d1": 0}, "substrate.c10 = 'soft'"),
    ],
)
def test_a_table_that_gives_no_law_is_refused(table, message):
    with pytest.raises(InputError, match=message):
        law_from_table(table, "substrate")


def test_every_key_has_one_unit():
    for kind in LAWS.values():
        for key, unit in (kind.units | kind.moduli).items():
            assert law_keys()[key] == unit, (kind, key)


@dataclass(frozen=True)
class Quadratic(Hyperelastic):
    mu: float
    d1: float = 0.0
    name: ClassVar[str] = "quadratic"
    units: ClassVar[dict[str, str]] = {"mu": "Pa", "d1": "1/Pa"}

    def energy(self, I1, I2, functions):
        return self.mu / 2 * (I1 - 3) + self.mu * (I2 - 3) ** 2


def test_a_law_must_be_registered_to_be_in_a_file(monkeypatch):
    with pytest.raises(InputError, match="law Quadratic: not registered, expected one of mooney-"):
        law_to_table(Quadratic(1e4))
    monkeypatch.setitem(LAWS, "quadratic", Quadratic)
    assert register_law(Quadratic) is Quadratic
    assert law_from_table(law_to_table(Quadratic(1e4)), "substrate") == Quadratic(1e4)
    assert Quadratic(1e4).shear_modulus == 1e4


def test_a_name_is_given_once():
    class Other(Quadratic):
        name = "gent"

    with pytest.raises(InputError, match="law = 'gent': the name is taken by Gent"):
        register_law(Other)
    with pytest.raises(InputError, match="law int: expected a name and the units"):
        register_law(int)
