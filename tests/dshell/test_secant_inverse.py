"""The update of a factor from steps: the secant equation, and the exact inverse of a quadratic."""

import numpy as np
import pytest

from dshell.solve.secant_inverse import SecantInverse

SIZE = 6


class Inverse:
    """The inverse of a matrix in the place of a factor."""

    def __init__(self, matrix):
        self._matrix = matrix

    def solve(self, right_side):
        return np.linalg.solve(self._matrix, right_side)


@pytest.fixture
def rng():
    return np.random.default_rng(4)


@pytest.fixture
def old(rng):
    return positive(rng)


@pytest.fixture
def new(rng, old):
    return old + positive(rng)


def positive(rng):
    root = rng.normal(size=(SIZE, SIZE))
    return root @ root.T + np.eye(SIZE)


def matrix_of(inverse):
    return np.column_stack([inverse.solve(column) for column in np.eye(SIZE)])


def test_without_steps_it_is_the_factor(old, rng):
    right = rng.normal(size=SIZE)
    assert SecantInverse(Inverse(old)).solve(right) == pytest.approx(np.linalg.solve(old, right))


def test_it_makes_the_last_step_of_its_change_and_stays_symmetric_and_positive(old, new, rng):
    inverse = SecantInverse(Inverse(old))
    for step in rng.normal(size=(3, SIZE)):
        inverse.add_pair(step, new @ step)
        assert inverse.solve(new @ step) == pytest.approx(step)
    found = matrix_of(inverse)
    assert found == pytest.approx(found.T)
    assert np.linalg.eigvalsh(found).min() > 0


def test_steps_that_the_new_stiffness_does_not_couple_teach_all_of_it(old, new):
    """The eigenvectors of the new one are such steps."""
    inverse = SecantInverse(Inverse(old))
    for step in np.linalg.eigh(new)[1].T:
        inverse.add_pair(step, new @ step)
    assert matrix_of(inverse) == pytest.approx(np.linalg.inv(new), rel=1e-9)


def test_a_force_that_turns_against_a_step_is_no_news(old, rng):
    inverse = SecantInverse(Inverse(old))
    step = rng.normal(size=SIZE)
    inverse.add_pair(step, -step)
    inverse.add_pair(step, np.zeros(SIZE))
    assert matrix_of(inverse) == pytest.approx(np.linalg.inv(old))


def test_the_right_side_is_left_as_it_is(old, new, rng):
    inverse = SecantInverse(Inverse(old))
    step, right = rng.normal(size=(2, SIZE))
    inverse.add_pair(step, new @ step)
    before = right.copy()
    inverse.solve(right)
    assert np.array_equal(right, before)
