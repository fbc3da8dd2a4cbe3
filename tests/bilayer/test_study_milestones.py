"""Milestones of many load paths on one axis: nothing falls on one place that is not the same."""

from bilayer.study.milestones import MilestoneAxis

UP = [(1.03, 1.03), (1.06, 1.06)]
LOOP = [*UP, (1.03, 1.03)]
PAIRS = [(1.2, 1.0), (1.2, 1.1), (1.2, 1.2)]


def test_one_path_is_the_axis_as_it_is():
    axis = MilestoneAxis.of([LOOP, LOOP])
    assert axis.places(LOOP).tolist() == [0, 1, 2]
    coordinates = axis.coordinates()
    assert coordinates["prestretch"][1].tolist() == [1.03, 1.06, 1.03]
    assert coordinates["visit"][1].tolist() == [0, 0, 1]


def test_several_paths_are_sorted_and_share_what_is_the_same():
    axis = MilestoneAxis.of([LOOP, [(1.09, 1.09), (1.06, 1.06)], UP])
    assert axis.coordinates()["prestretch"][1].tolist() == [1.03, 1.03, 1.06, 1.09]
    assert axis.places(LOOP).tolist() == [0, 2, 1]
    assert axis.places([(1.09, 1.09), (1.06, 1.06)]).tolist() == [3, 2]


def test_pairs_with_one_larger_stretch_have_places_of_their_own():
    axis = MilestoneAxis.of([PAIRS, PAIRS[1:], [(1.0, 1.2)]])
    assert axis.places(PAIRS[1:]).tolist() == [2, 3]
    coordinates = axis.coordinates()
    assert coordinates["prestretch"][1].tolist() == 4 * [1.2]
    assert coordinates["prestretch_y"][1].tolist() == [1.2, 1.0, 1.1, 1.2]
    assert "visit" not in coordinates
