"""The driver alone, on a path that is a line: a point that walks from number to number."""

from dataclasses import dataclass

import pytest

from bilayer.errors import ComputationError
from bilayer.solvers.contract import TargetMissedError
from bilayer.solvers.path import follow_path, run_path


@dataclass(frozen=True)
class Steps:
    iterations: int = 0
    load_steps: int = 0

    def __add__(self, other):
        return Steps(self.iterations + other.iterations, self.load_steps + other.load_steps)


@dataclass(frozen=True)
class Place:
    at: float
    share: float
    effort: Steps


class Walk:
    """Walks in two steps to a number; some numbers cannot be reached."""

    def __init__(self, failures=()):
        self._at, self._failures = 0.0, dict(failures)

    def approach(self, target):
        start = self._at
        for share in (0.5, 1.0):
            if share == 1 and target in self._failures:
                raise self._failures[target]
            self._at = start + share * (target - start)
            yield Place(self._at, share, Steps(3, 1))

    def stopped(self):
        return Place(self._at, 0.5, Steps(7, 0))


def test_targets_come_in_the_order_that_is_asked_for():
    steps = list(follow_path(Walk(), [2.0, 1.0, 2.0, 2.0]))
    reached = [step for step in steps if step.is_at_target]
    assert [step.point.at for step in steps] == [1.0, 2.0, 1.5, 1.0, 1.5, 2.0, 2.0, 2.0]
    assert [step.index for step in reached] == [0, 1, 2, 3]
    assert [step.effort for step in reached] == [Steps(6, 2)] * 4
    assert [step.fraction for step in steps] == [k / 8 for k in range(1, 9)]


def test_observers_are_told_before_the_caller_in_their_order():
    told = []
    observers = [lambda step: told.append(("a", step)), lambda step: told.append(("b", step))]
    for step in follow_path(Walk(), [1.0], observers):
        assert told[-2:] == [("a", step), ("b", step)]
    assert len(told) == 4


@pytest.mark.parametrize("error", [ComputationError("lost"), MemoryError()])
def test_a_path_that_ends_tells_where_and_what_was_spent(error):
    *_, last = follow_path(Walk({2.0: error}), [1.0, 2.0, 3.0])
    assert last.failure is error
    assert not last.is_at_target
    assert (last.index, last.point.at, last.effort) == (1, 1.5, Steps(10, 1))


def test_a_missed_target_is_followed_by_the_next():
    steps = list(follow_path(Walk({2.0: TargetMissedError("no")}), [1.0, 2.0, 3.0]))
    ends = [(step.index, step.is_at_target) for step in steps if step.ends_target]
    assert ends == [(0, True), (1, False), (2, True)]


def test_another_error_passes_as_it_is():
    with pytest.raises(TypeError, match="a fault"):
        run_path(Walk({1.0: TypeError("a fault")}), [1.0])


def test_a_run_that_goes_on_begins_with_a_later_target():
    steps = follow_path(Walk(), [1.0, 2.0, 3.0], first=2)
    assert [(step.index, step.fraction) for step in steps] == [(2, 2.5 / 3), (2, 1.0)]


def test_time_is_that_of_the_path_alone(monkeypatch):
    clock = iter(range(100))
    monkeypatch.setattr("bilayer.solvers.path.time.perf_counter", lambda: next(clock))

    def slow(step):
        for _ in range(10):
            next(clock)

    steps = list(follow_path(Walk(), [1.0], [slow]))
    assert [step.wall_time for step in steps] == [1, 2]
