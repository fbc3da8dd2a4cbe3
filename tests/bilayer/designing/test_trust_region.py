"""The search: bounds, constraints, failures, with and without a curvature."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from bilayer.designing.trust_region import Limits, NoValueError, search, updated


@dataclass(frozen=True, eq=False)
class Value:
    value: float
    gradient: np.ndarray
    curvature: np.ndarray | None = None
    is_admissible: bool = True
    margins: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True, eq=False)
class At:
    point: np.ndarray
    value: float
    gradient: np.ndarray
    curvature: np.ndarray
    is_admissible: bool = True
    margins: np.ndarray = field(default_factory=lambda: np.empty(0))


CENTRE = np.array([0.3, 0.9, 1.4])
STIFF = np.array([[4.0, 1.0, 0.0], [1.0, 30.0, 2.0], [0.0, 2.0, 1.0]])


def bowl(point, best, curvature=None):
    away = point - CENTRE
    return Value(float(away @ STIFF @ away / 2), STIFF @ away, curvature)


def last(evaluate, count, constraints=None, start=0.5):
    return list(search(evaluate, np.full(3, start), Limits(count), constraints))[-1]


def test_the_least_value_within_the_bounds_is_found():
    found = last(bowl, 40)
    assert found.point[2] == pytest.approx(1.0)
    assert np.abs(found.best.gradient[:2]).max() < 1e-3


def test_a_known_curvature_takes_fewer_steps():
    known = last(lambda point, best: bowl(point, best, STIFF), 40)
    assert known.best.value == pytest.approx(last(bowl, 40).best.value, rel=1e-4)
    assert known.evaluations < last(bowl, 40).evaluations


def test_a_constraint_holds():
    def margins(point):
        return np.array([1.0 - point.sum()])

    found = last(bowl, 40, margins, start=0.3)
    assert found.point.sum() == pytest.approx(1.0, abs=1e-6)


def test_a_margin_that_only_an_evaluation_knows_holds():
    """A disc about the start, whose slopes the search has to learn."""
    start = np.full(3, 0.5)
    tried = []

    def guarded(point, best):
        tried.append(point)
        margin = np.array([0.04 - float((point - start) @ (point - start))])
        found = bowl(point, best, STIFF)
        return Value(found.value, found.gradient, STIFF, True, margin)

    found = last(guarded, 40)
    free = last(lambda point, best: bowl(point, best, STIFF), 40)
    assert free.best.value < found.best.value  # the margin costs something
    assert 0 <= found.best.margins[0] < 2e-3  # and holds
    along = found.best.gradient @ (found.point - start)
    assert along < -0.97 * np.linalg.norm(found.best.gradient) * 0.2  # the best place of the disc


def test_a_margin_that_is_short_at_first_does_not_become_shorter():
    def guarded(point, best):
        found = bowl(point, best, STIFF)
        return Value(found.value, found.gradient, STIFF, True, np.array([0.3 - point[0]]))

    found = last(guarded, 20)
    assert found.point[0] <= 0.5
    assert found.best.value < bowl(np.full(3, 0.5), None).value


def test_the_box_shrinks_where_there_is_no_value_and_the_search_goes_on():
    tried = []

    def half_blind(point, best):
        tried.append(point)
        if point[0] < 0.4:
            raise NoValueError("nothing here")
        return bowl(point, best)

    found = last(half_blind, 40)
    assert any(point[0] < 0.4 for point in tried)
    assert 0.4 <= found.point[0] < 0.42


def test_a_step_that_was_in_vain_is_not_tried_again_soon():
    """Far from the least value all steps are as long as the box, and none longer succeeds."""

    def short_sighted(point, best):
        if best is not None and np.abs(point - best.point).max() > 0.06:
            raise NoValueError("too far")
        here = bowl(point, best)
        return At(point, here.value, here.gradient, STIFF)

    steps = list(search(short_sighted, np.array([0.3, 0.9, 0.0]), Limits(12, 0.05)))
    assert [step.failure != "" for step in steps[:5]] == [False, False, True, False, False]
    in_vain = steps[1].radius
    assert in_vain == pytest.approx(0.1)
    assert steps[4].radius == pytest.approx(0.7 * in_vain * 1.2**2)  # and not 0.12


def test_it_does_not_stay_where_it_may_not():
    def guarded(point, best):
        here = bowl(point, best)
        return Value(here.value, here.gradient, None, bool(point[1] < 0.7))

    assert last(guarded, 30).point[1] < 0.7


def test_the_first_failure_is_told():
    def blind(point, best):
        raise NoValueError("nothing at all")

    with pytest.raises(NoValueError, match="at all"):
        list(search(blind, np.zeros(2), Limits(5)))


def test_the_update_stays_positive_definite():
    rng = np.random.default_rng(2)
    curvature = np.eye(4)
    for _ in range(30):
        curvature = updated(curvature, rng.normal(size=4), rng.normal(size=4))
    assert np.linalg.eigvalsh(curvature).min() > 0
