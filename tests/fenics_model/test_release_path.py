import pytest

from fenics_model.path.release_path import ReleasePath


def test_milestones_are_on_the_path():
    path = ReleasePath([(1.03, 1.03), (1.06, 1.01)])
    assert path.milestones == pytest.approx([0.03, 0.06])
    assert path.stretch(0.0) == (1.0, 1.0)
    assert path.stretch(0.015) == pytest.approx((1.015, 1.015))
    assert path.stretch(path.milestones[0]) == pytest.approx((1.03, 1.03), abs=1e-15)
    assert path.stretch(path.milestones[1]) == pytest.approx((1.06, 1.01), abs=1e-15)


def test_the_imperfection_is_gone_at_every_milestone():
    path = ReleasePath([(1.02, 1.02), (1.04, 1.04)])
    first, second = path.milestones
    assert path.imperfection_fraction(0.0) == 1.0
    assert path.imperfection_fraction(first / 2) == pytest.approx(0.5)
    assert path.imperfection_fraction((first + second) / 2) == pytest.approx(1.0)
    assert [path.imperfection_fraction(t) for t in (first, second)] == [0.0, 0.0]


def test_the_weight_comes_on_before_the_prestretch():
    path = ReleasePath([(1.02, 1.02), (1.04, 1.04)], weight_way=0.01)
    assert path.milestones == pytest.approx([0.03, 0.05])
    assert [path.weight_fraction(t) for t in (0.0, 0.005, 0.01, 0.05)] == [0.0, 0.5, 1.0, 1.0]
    assert path.stretch(0.01) == (1.0, 1.0)
    assert path.stretch(0.02) == pytest.approx((1.01, 1.01))
    assert path.imperfection_fraction(0.015) == pytest.approx(0.5)
    assert path.imperfection_fraction(path.milestones[0]) == 0.0


def test_an_unstretched_milestone_still_has_a_way():
    path = ReleasePath([(1.0, 1.0)])
    assert path.milestones[0] > 0
    assert path.stretch(path.milestones[0]) == (1.0, 1.0)
    assert path.weight_fraction(path.milestones[0]) == 1.0
