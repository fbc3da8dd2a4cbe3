import pytest

from fenics_model.path.load_schedule import LoadSchedule


def test_milestones_are_on_the_path():
    path = LoadSchedule([(1.03, 1.03), (1.06, 1.01)])
    assert path.milestones == pytest.approx([0.03, 0.06])
    assert path.stretch(0.0) == (1.0, 1.0)
    assert path.stretch(0.015) == pytest.approx((1.015, 1.015))
    assert path.stretch(path.milestones[0]) == pytest.approx((1.03, 1.03), abs=1e-15)
    assert path.stretch(path.milestones[1]) == pytest.approx((1.06, 1.01), abs=1e-15)


def test_the_imperfection_is_gone_at_every_milestone():
    path = LoadSchedule([(1.02, 1.02), (1.04, 1.04)])
    first, second = path.milestones
    assert path.imperfection_fraction(0.0) == 1.0
    assert path.imperfection_fraction(first / 2) == pytest.approx(0.5)
    assert path.imperfection_fraction((first + second) / 2) == pytest.approx(1.0)
    assert [path.imperfection_fraction(t) for t in (first, second)] == [0.0, 0.0]


def test_the_weight_comes_on_before_the_prestretch():
    path = LoadSchedule([(1.02, 1.02), (1.04, 1.04)], weight_way=0.01)
    assert path.milestones == pytest.approx([0.03, 0.05])
    assert [path.weight_fraction(t) for t in (0.0, 0.005, 0.01, 0.05)] == [0.0, 0.5, 1.0, 1.0]
    assert path.stretch(0.01) == (1.0, 1.0)
    assert path.stretch(0.02) == pytest.approx((1.01, 1.01))
    assert path.imperfection_fraction(0.015) == pytest.approx(0.5)
    assert path.imperfection_fraction(path.milestones[0]) == 0.0


def test_an_unstretched_milestone_still_has_a_way():
    path = LoadSchedule([(1.0, 1.0)])
    assert path.milestones[0] > 0
    assert path.stretch(path.milestones[0]) == (1.0, 1.0)
    assert path.weight_fraction(path.milestones[0]) == 1.0


def test_the_way_down_is_as_long_as_the_way_up():
    path = LoadSchedule([(1.03, 1.03), (1.06, 1.06), (1.03, 1.03), (1.03, 1.03)])
    assert path.milestones == pytest.approx([0.03, 0.06, 0.09, 0.09])
    assert path.stretch(0.075) == pytest.approx((1.045, 1.045))
    assert path.last == (1.03, 1.03)
    assert [path.imperfection_fraction(t) for t in path.milestones] == pytest.approx([0] * 4)
    assert path.imperfection_fraction(0.075) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("target", "back"),
    [((1.03, 1.03), True), ((0.99, 0.99), True), ((1.09, 1.09), False), ((1.03, 1.06), False)],
)
def test_a_path_knows_when_it_turns_back(target, back):
    assert LoadSchedule([(1.03, 1.03), (1.06, 1.06), target]).turns_back == back


def test_a_path_is_left_where_it_has_come_to():
    path = LoadSchedule([(1.03, 1.03), (1.06, 1.06)], weight_way=0.02)
    path.leave_at(0.06)
    assert path.last == pytest.approx((1.04, 1.04))
    assert path.add_target((1.04, 1.02)) == pytest.approx(0.08)
    assert path.stretch(0.07) == pytest.approx((1.04, 1.03))
    assert path.milestones == pytest.approx([0.05, 0.06, 0.08])


def test_before_the_weight_is_on_only_the_targets_are_left():
    path = LoadSchedule([(1.03, 1.03)], weight_way=0.02)
    path.leave_at(0.01)
    assert path.milestones == []
    assert path.add_target((1.05, 1.05)) == pytest.approx(0.07)
