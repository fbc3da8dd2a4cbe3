"""Rigid alignment: undoes a rigid motion, never reflects, weighs its points."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bilayer.alignment import aligned, rms_distance

POINTS = np.random.default_rng(2).normal(size=(50, 3))
WEIGHTS = np.random.default_rng(3).uniform(0.1, 1, 50)
TURN = Rotation.from_rotvec([1.0, -2.0, 0.5])


def test_a_rigid_motion_is_undone():
    moved = TURN.apply(POINTS) + np.array([3, 2, 1])
    assert aligned(moved, POINTS, WEIGHTS) == pytest.approx(POINTS, abs=1e-12)
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
    best = aligned(other, POINTS, WEIGHTS)
    centre = np.average(POINTS, axis=0, weights=WEIGHTS)
    for vector in 0.05 * np.random.default_rng(6).normal(size=(20, 3)):
        turned = Rotation.from_rotvec(vector).apply(best - centre) + centre
        assert WEIGHTS @ np.sum((turned - POINTS) ** 2, axis=1) > WEIGHTS @ np.sum(
            (best - POINTS) ** 2, axis=1
        )
