"""Strips that bend in one plane: rungs 3, 5 and 11 of the verification ladder."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.solid_strips import THICKNESS, Cantilever, flexed_strip, flexure

STRETCH = 1.06


def test_the_exact_solution_is_the_published_one():
    angle, radius = flexure(STRETCH)
    assert angle == pytest.approx(39.23298, rel=1e-5)
    assert radius * angle == pytest.approx(0.976057, rel=1e-5)
    inner = np.sqrt(radius**2 - 2 * THICKNESS / (angle * STRETCH))
    assert inner == pytest.approx(23.8924e-3, rel=1e-5)


def test_a_strip_bends_as_the_exact_solution():
    angle, stretch = flexed_strip(STRETCH)
    exact_angle, exact_radius = flexure(STRETCH)
    assert angle == pytest.approx(exact_angle, rel=0.005)
    assert stretch == pytest.approx(exact_angle * exact_radius, rel=0.002)


@pytest.mark.parametrize("poisson_ratio", [0.48, 0.49, 0.499, 0.5])
def test_a_plate_one_element_thick_does_not_lock(poisson_ratio):
    assert Cantilever(poisson_ratio).energy_ratio() == pytest.approx(1.0, rel=0.02)


def test_a_heavy_cantilever_hangs_as_the_elastica():
    (drop,) = Cantilever(0.5, thickness=0.5e-3).weighed([5.0])
    assert drop == pytest.approx(0.495905, rel=0.01)
