"""The two-sided distance: its gradient, its place, and what fools a one-sided one."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bilayer.designing import targets
from bilayer.designing.distance import Place, TargetDistance
from bilayer.designing.targets import cap, height_map, saddle
from bilayer.geometry.surface import Surface
from bilayer.measures.hemisphere import flat_disc_distance


@pytest.fixture(autouse=True)
def few_nodes(monkeypatch):
    """Coarse formulas, so that the tests are quick."""
    monkeypatch.setattr(targets, "NODES", 150)


def bent(surface, amount=0.002):
    """A surface that is not the target, at another place."""
    x, y, z = surface.points.T
    points = np.column_stack([1.05 * x, y, 0.9 * z + amount * np.sin(200 * x)])
    turned = Rotation.from_rotvec([0.2, -0.1, 0.5]).apply(points)
    return Surface(np.add(turned, [0.01, -0.02, 0.005]), surface.triangles)


@pytest.fixture
def small(few_nodes):
    """A coarse saddle."""
    fine = saddle(0.02, 30.0)
    few = np.linspace(0, len(fine.points) - 1, 60).astype(int)
    return height_map(fine.points[few])


@pytest.mark.parametrize("is_size_free", [False, True])
def test_the_gradient_is_that_of_the_distance_at_its_best_place(small, is_size_free):
    """To within the search of the place: the derivative by the place is left out."""
    distance = TargetDistance(saddle(0.02, 40.0), is_size_free)
    shape = bent(small)
    best = distance.measure_anew(shape)

    def value(points):
        return distance.measure(Surface(points, shape.triangles), best.place).mean_square

    direction = np.sin(np.arange(shape.points.size)).reshape(-1, 3)
    step = 1e-6
    expected = (value(shape.points + step * direction) - value(shape.points - step * direction)) / (
        2 * step
    )
    assert np.sum(best.gradient * direction) == pytest.approx(expected, rel=1e-3)


def test_the_curvature_is_that_of_the_residuals(small):
    """Where the target is nearly met, the second difference is Gauss and Newton's."""
    target = saddle(0.02, 30.0)
    distance = TargetDistance(target)
    shape = Surface(target.points, target.triangles)
    place = Place(np.eye(3), np.zeros(3))
    x, y, _ = shape.points.T
    normal_motion = np.zeros_like(shape.points)
    normal_motion[:, 2] = np.sin(150 * x) * np.cos(100 * y)
    found = distance.curvature(shape, place, normal_motion[None])[0, 0]
    step = 2e-4
    ahead = distance.measure(Surface(shape.points + step * normal_motion, shape.triangles), place)
    assert 2 * ahead.mean_square / step**2 == pytest.approx(found, rel=0.05)


def test_a_target_is_found_wherever_the_shape_lies():
    target = saddle(0.02, 30.0)
    moved = Surface(
        Rotation.from_rotvec([0.4, 1.9, -2.0]).apply(target.points) + 0.3, target.triangles
    )
    assert TargetDistance(target).measure_anew(moved).rms < 5e-5


def test_a_free_size_is_found():
    target = cap(0.02, 1.2)
    larger = Surface(1.3 * target.points, target.triangles)
    found = TargetDistance(target, is_size_free=True).measure_anew(larger)
    assert found.rms < 1e-4
    assert found.place.size == pytest.approx(1.3, rel=1e-3)
    assert TargetDistance(target).measure_anew(larger).rms > 1e-3


def test_a_shape_that_lies_on_a_part_of_the_target_is_far_from_it():
    """All of it is on the target, as a crumpled sheet is; the target is not on it."""
    part = cap(0.02, 0.5)
    found = TargetDistance(cap(0.02)).measure_anew(part)
    assert found.rms > 0.004


def test_a_disc_is_as_far_from_the_hemisphere_as_the_measure_says():
    disc = cap(10.0, 0.04 / 10)
    found = TargetDistance(cap(2 * 0.04 / np.pi)).measure_anew(disc)
    assert found.rms == pytest.approx(flat_disc_distance(0.04), rel=0.02)
