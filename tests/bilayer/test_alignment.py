"""Rigid alignment: undoes a rigid motion, never reflects, weighs its points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bilayer.geometry.alignment import align, move_onto_held_points, rms_distance

POINTS = np.random.default_rng(2).normal(size=(50, 3))
WEIGHTS = np.random.default_rng(3).uniform(0.1, 1, 50)
TURN = Rotation.from_rotvec([1.0, -2.0, 0.5])


def test_a_rigid_motion_is_undone():
    moved = TURN.apply(POINTS) + np.array([3, 2, 1])
    assert align(moved, POINTS, WEIGHTS) == pytest.approx(POINTS, abs=1e-12)
    assert rms_distance(moved, POINTS, WEIGHTS) < 1e-12


def test_a_mirror_image_stays_apart():
    assert rms_distance(POINTS * [1, 1, -1], POINTS, WEIGHTS) > 0.3


def test_the_distance_has_no_direction():
    other = POINTS + 0.1 * np.random.default_rng(4).normal(size=POINTS.shape)
    forth, back = rms_distance(other, POINTS, WEIGHTS), rms_distance(POINTS, other, WEIGHTS)
    assert forth == pytest.approx(back, rel=1e-12)


def test_a_point_without_weight_does_not_count():
    spoiled, weights = POINTS.copy(), WEIGHTS.copy()
    spoiled[7] += 100
    weights[7] = 0
    assert rms_distance(TURN.apply(spoiled), POINTS, weights) < 1e-12
    assert rms_distance(TURN.apply(spoiled), POINTS, WEIGHTS) > 1


def test_no_smaller_distance_at_another_rotation():
    other = POINTS + 0.3 * np.random.default_rng(5).normal(size=POINTS.shape)
    best = align(other, POINTS, WEIGHTS)
    centre = np.average(POINTS, axis=0, weights=WEIGHTS)
    for vector in 0.05 * np.random.default_rng(6).normal(size=(20, 3)):
        turned = Rotation.from_rotvec(vector).apply(best - centre) + centre
        assert WEIGHTS @ np.sum((turned - POINTS) ** 2, axis=1) > WEIGHTS @ np.sum(
            (best - POINTS) ** 2, axis=1
        )


@pytest.mark.parametrize("held", [(0, 1, 2), (0, 1, 3), (2, 1, 0)])
def test_a_placed_shape_has_six_coordinates_of_the_flat_state(held):
    flat = np.array([[0.1, 0], [1, 0.2], [-0.3, 1], [0.2, -0.8], [-1, 0]])
    bent = np.column_stack([0.9 * flat, 0.1 * (flat**2).sum(axis=1)])
    moved = move_onto_held_points(TURN.apply(bent) + np.array([3, 2, 1]), flat, held)
    a, b, c = held
    assert moved[a] == pytest.approx([*flat[a], 0], abs=1e-12)
    assert moved[b, 1:] == pytest.approx([flat[b, 1], 0], abs=1e-12)
    assert moved[c, 2] == pytest.approx(0, abs=1e-12)
    assert rms_distance(moved, bent, np.ones(5)) < 1e-12
    moved_area, flat_area = (
        np.linalg.det(points[[b, c], :2] - points[a, :2]) for points in (moved, flat)
    )
    assert moved_area * flat_area > 0
