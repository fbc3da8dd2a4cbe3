"""Similarity of pictures of heights: a formula written out, itself, and what is far from it."""

import numpy as np
import pytest

from bilayer.designing import height_image, targets
from bilayer.designing.height_image import plain_cap, similarity, structural_similarity
from bilayer.designing.targets import cap, saddle


@pytest.fixture(autouse=True)
def few_nodes(monkeypatch):
    monkeypatch.setattr(targets, "NODES", 150)
    monkeypatch.setattr(height_image, "PIXELS", 96)


def test_the_similarity_is_that_of_the_formula():
    """At one place, with the window's weights written out; the mean is that of all places."""
    rng = np.random.default_rng(2)
    first, second = rng.random((2, 11, 11))
    away = np.arange(-5, 6)
    weights = np.exp(-np.add.outer(away**2, away**2) / (2 * 1.5**2))
    weights /= weights.sum()
    a, b = np.sum(weights * first), np.sum(weights * second)
    own, other = np.sum(weights * first**2) - a**2, np.sum(weights * second**2) - b**2
    shared = np.sum(weights * first * second) - a * b
    expected = (2 * a * b + 1e-4) * (2 * shared + 9e-4)
    expected /= (a**2 + b**2 + 1e-4) * (own + other + 9e-4)
    assert structural_similarity(first, second, 1.0) == pytest.approx(expected)


def test_a_plain_cap_has_the_area_and_the_height():
    target = saddle(0.02, 20.0)
    found = plain_cap(target)
    assert found.areas.sum() == pytest.approx(target.areas.sum(), rel=0.03)
    assert np.ptp(found.points[:, 2]) == pytest.approx(np.ptp(target.points[:, 2]), rel=0.02)


def test_the_target_itself_is_similar_and_the_flat_sheet_is_not():
    target, sheet = saddle(0.02, 40.0), saddle(0.022, 1e-6)
    found = similarity(target, target, sheet)
    assert found.shape > 0.99
    assert found.plain_cap < 0.8
    assert found.flat < 0.8


def test_a_cap_is_similar_to_a_cap():
    target = cap(0.03, 1.0)
    assert similarity(target, cap(0.03, 0.9), cap(10.0, 0.003)).plain_cap > 0.95
