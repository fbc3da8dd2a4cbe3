"""Derivatives by the parameters of a specimen, also by those that are zero."""

import numpy as np
import pytest

from bilayer import InputError, MooneyRivlin, Ogden, paper_specimen
from bilayer.solvers.parameters import difference_by

STRETCH = (1.06, 1.04)
INCOMPRESSIBLE = paper_specimen().with_layer("substrate", material=MooneyRivlin(2e4, 0.0, 0.0))


def numbers_of(specimen, stretch):
    """A smooth function of everything: each number and its square, in units of its size."""
    law = specimen.layer("substrate").material
    sizes = np.array([1.0, 1.0, 1.0, 1e-3, law.shear_modulus, 1 / law.shear_modulus])
    found = [*stretch, specimen.gravity, specimen.layer("substrate").thickness, law.c01, law.d1]
    scaled = np.array(found) / sizes
    return np.concatenate([scaled, scaled**2])


@pytest.mark.parametrize(
    ("parameter", "place", "size"),
    [
        ("prestretch.x", 0, 1.0),
        ("prestretch.y", 1, 1.0),
        ("gravity", 2, 1.0),
        ("substrate.thickness", 3, 1e-3),
        ("substrate.material.d1", 5, 1 / 4e4),
    ],
)
def test_a_derivative_is_exact_to_the_second_order(parameter, place, size):
    """Gravity and d1 are zero, and may not be less."""
    found = difference_by(numbers_of, INCOMPRESSIBLE, STRETCH, parameter) * size
    value = numbers_of(INCOMPRESSIBLE, STRETCH)[place]
    expected = np.zeros(12)
    expected[place], expected[6 + place] = 1.0, 2 * value
    assert found == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize(
    "parameter", ["strips", "substrate.colour", "bond.thickness", "substrate.material.mu"]
)
def test_what_is_no_parameter_is_told(parameter):
    specimen = INCOMPRESSIBLE.with_layer("substrate", material=Ogden([2e4], [2.0]))
    with pytest.raises(InputError, match=r"expected prestretch, .* with a layer of \['substrate'"):
        difference_by(numbers_of, specimen, STRETCH, parameter)
