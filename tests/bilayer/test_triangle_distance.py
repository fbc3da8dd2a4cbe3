"""Distance of triangles: the ways in which two of them are nearest, and crossing ones."""

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from bilayer.contact.triangle_distance import triangle_distance

FLAT_TRIANGLE = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0]])


def distance(first, second):
    return triangle_distance(np.array([first]), np.array([second], dtype=float))[0]


@pytest.mark.parametrize(
    ("other", "expected"),
    [
        ([[1, 1, 0.5], [1, 2, 3], [2, 1, 3]], 0.5),  # a corner above the inside
        ([[-3, -1, 2], [-3, -3, 2], [-3, -2, 5]], np.sqrt(14)),  # corner to corner
        ([[2, -1, -2], [2, -1, 2], [2, -5, 0]], 1),  # edge beside edge
        ([[-1, 1, 0.3], [5, 1, 0.3], [2, 1, 6]], 0.3),  # edge above face and edges
        ([[1, 1, -1], [1, 1, 1], [1.2, 1.2, 2]], 0),  # pierced by an edge
        ([[-1, 1, -1], [5, 1, -1], [2, 1, 6]], 0),  # crossed from side to side
        ([[1, -1, 0], [1, 5, 0], [9, 9, 0]], 0),  # overlapping in one plane
        ([[5, 0, 0], [8, 1, 0], [8, -1, 0]], 1),  # apart in one plane
    ],
)
def test_known_distances(other, expected):
    assert distance(FLAT_TRIANGLE, other) == pytest.approx(expected, abs=1e-12)
    assert distance(np.array(other, dtype=float), FLAT_TRIANGLE) == pytest.approx(
        expected, abs=1e-12
    )


def by_optimisation(first, second):
    """The convex problem in barycentric coordinates, by a general method."""

    def squared(weights):
        return np.sum((weights[:3] @ first - weights[3:] @ second) ** 2)

    sums = [
        {"type": "eq", "fun": lambda w, part=part: w[part].sum() - 1}
        for part in (slice(3), slice(3, 6))
    ]
    found = minimize(
        squared, np.full(6, 1 / 3), bounds=[(0, 1)] * 6, constraints=sums,
        options={"ftol": 1e-15, "maxiter": 300},
    )  # fmt: skip
    return np.sqrt(found.fun)


def test_random_triangles_against_a_general_optimiser():
    random = np.random.default_rng(5)
    first, second = 2 * random.normal(size=(2, 40, 3, 3))
    second += 0.5 * random.normal(size=(40, 1, 3))
    expected = [by_optimisation(*pair) for pair in zip(first, second, strict=True)]
    found = triangle_distance(first, second)
    assert found == pytest.approx(expected, abs=1e-4)
    assert np.count_nonzero(found > 0.01) > 10
    assert np.count_nonzero(found < 1e-12) > 5


def test_a_rigid_motion_changes_nothing():
    first, second = np.random.default_rng(6).normal(size=(2, 50, 3, 3))
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    moved = triangle_distance(first @ turn.T + 2, second @ turn.T + 2)
    assert moved == pytest.approx(triangle_distance(first, second), abs=1e-12)
