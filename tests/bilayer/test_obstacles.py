"""The barrier against a plane and a sphere."""

import numpy as np
import pytest
from verification.derivatives import derivative_by_points

from bilayer.contact.obstacles import ObstacleBarrier, Plane, Sphere
from bilayer.contact.several import SeveralBarriers

RANGE, STIFFNESS, STEP = 2e-4, 1e4, 2e-8
PLANE = Plane((0.0, 0.0, 1e-3), (0.0, 0.6, 0.8))
SPHERE = Sphere((1e-3, 0.0, 0.0), 5e-3)


def points_at(obstacle, distances):
    """Return points on rays from inside an obstacle, at distances from its surface."""
    rng = np.random.default_rng(0)
    start = 6e-3 * rng.normal(size=(len(distances), 3)) + np.array([0.0, 3e-3, 4e-3])
    return start + (distances - obstacle.distance(start))[:, None] * obstacle.normals(start)


@pytest.fixture(params=[PLANE, SPHERE], ids=["plane", "sphere"])
def obstacle(request):
    return request.param


@pytest.fixture
def barrier(obstacle):
    areas = np.random.default_rng(1).uniform(1e-6, 3e-6, 12)
    return ObstacleBarrier([obstacle], areas, range=RANGE, stiffness=STIFFNESS)


@pytest.fixture
def points(obstacle):
    return points_at(obstacle, np.linspace(0.2, 1.35, 12) * RANGE)


def test_derivatives_agree_with_finite_differences(barrier, points):
    found = barrier.at(points)
    assert 0 < found.pairs < 12
    expected = derivative_by_points(lambda x: barrier.at(x).energy, points, STEP)
    assert np.abs(found.gradient.reshape(-1) - expected).max() < 1e-7 * np.abs(expected).max()
    expected = derivative_by_points(lambda x: barrier.at(x).gradient.reshape(-1), points, STEP)
    assert np.abs(found.hessian() - expected).max() < 1e-7 * np.abs(expected).max()
    values = np.linalg.eigvalsh(found.convex_hessian().toarray())
    assert values.min() > -1e-9 * values.max()


def test_points_are_pressed_outward_and_only_within_range(barrier, points, obstacle):
    forces = -barrier.at(points).gradient
    along = (forces * obstacle.normals(points)).sum(axis=1)
    near = obstacle.distance(points) < RANGE
    assert (along[near] > 0).all()
    assert (along[~near] == 0).all()
    assert barrier.at(points).smallest_gap == pytest.approx(0.2 * RANGE)
    far = points_at(obstacle, np.full(12, 2 * RANGE))
    assert barrier.at(far).energy == 0
    assert np.isinf(barrier.at(far).smallest_gap)


def test_ways_end_where_a_point_touches(barrier, obstacle):
    start = points_at(obstacle, np.linspace(1e-3, 2e-3, 12))
    end = start - 1.5e-3 * obstacle.normals(start)
    share = barrier.free_share(start, end)
    assert share == pytest.approx(1e-3 / 1.5e-3)
    assert not barrier.is_crossed(start + 0.999 * share * (end - start))
    assert barrier.is_crossed(end)
    assert np.isinf(barrier.at(end).energy)
    assert barrier.free_share(start, start) == 1
    assert not barrier.stays_clear(start, start + 0.6 * (end - start))
    assert barrier.stays_clear(start, start + 0.5 * (end - start))


def test_a_way_through_a_ball_is_seen():
    """Both of its ends are outside."""
    barrier = ObstacleBarrier([SPHERE], np.ones(1), range=RANGE, stiffness=STIFFNESS)
    start, end = np.array([[-9e-3, 1e-3, 0]]), np.array([[11e-3, 1e-3, 0]])
    half = np.sqrt(5e-3**2 - 1e-3**2)
    assert barrier.free_share(start, end) == pytest.approx((10e-3 - half) / 20e-3)
    assert not barrier.stays_clear(start, end)


def test_barriers_add_up():
    """A plane and a large ball under it that touches it."""
    rng, areas = np.random.default_rng(2), np.full(12, 2e-6)
    points = np.column_stack([rng.uniform(-1e-3, 1e-3, (12, 2)), rng.uniform(0.2, 1.2, 12) * RANGE])
    floor, ball = Plane((0, 0, 0), (0, 0, 1)), Sphere((0, 0, -1.0), 1.0)
    parts = [
        ObstacleBarrier([obstacle], areas, range=RANGE, stiffness=STIFFNESS)
        for obstacle in (floor, ball)
    ]
    both = ObstacleBarrier([floor, ball], areas, range=RANGE, stiffness=STIFFNESS)
    found, expected = SeveralBarriers(parts).at(points), both.at(points)
    assert found.energy == pytest.approx(expected.energy)
    assert found.gradient == pytest.approx(expected.gradient)
    assert found.pairs == expected.pairs
    assert np.abs(found.hessian() - expected.hessian()).max() < 1e-9
