"""The shapes of a start that lead to the milestones of a run, in whatever order they come."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from made_results import cap_result, small_specimen

from bilayer import InputError, MeshSize, generate_mesh
from bilayer.results.schema import result_mesh
from bilayer.results.start_shapes import StartShapes
from bilayer.results.starting import with_waypoints

UP_AND_DOWN = [1.03, 1.06, 1.03, 1.06]


@pytest.fixture(scope="module")
def start():
    """A result that goes up and down; no two of its shapes are alike."""
    result = cap_result(small_specimen(UP_AND_DOWN))
    result["position"] = result["position"] * np.array([1, 1.1, 1.2, 1.3])[:, None, None]
    return result


def rows_of(start, milestones):
    """The rows of the start that lead to each milestone, and how far each is from it."""
    shapes = StartShapes.of(start, result_mesh(start))
    ways = pairwise([(1.0, 1.0), *((x, x) for x in milestones)])
    found = [shapes.take_shapes(*way) for way in ways]
    rows = [[row_of(start, shape.shape) for shape in way] for way in found]
    return rows, [shape.remaining for way in found for shape in way]


def row_of(start, shape):
    return [np.array_equal(shape, row) for row in start["position"].values].index(True)


def test_a_prestretch_that_comes_again_has_its_own_shape(start):
    rows, remaining = rows_of(start, UP_AND_DOWN)
    assert [way[-1] for way in rows] == [0, 1, 2, 3]
    assert [r for r in remaining if r == 0] == [0] * 4


def test_waypoints_lie_on_the_way_down_too():
    specimen = with_waypoints(small_specimen([1.1, 1.01, 1.1]))
    assert specimen.prestretch.nominal == pytest.approx([1.05, 1.1, 1.055, 1.01, 1.055, 1.1])
    start = cap_result(specimen)
    start["position"] = start["position"] * np.linspace(1, 2, 6)[:, None, None]
    rows, remaining = rows_of(start, [1.1, 1.01, 1.1])
    assert [[way[0], way[-1]] for way in rows[1:]] == [[2, 3], [4, 5]]
    assert rows[0][-1] == 1
    assert remaining[-4:] == pytest.approx([0.045, 0, 0.045, 0])


@pytest.mark.parametrize(
    ("stretch", "row"), [((1.031, 1.031), 0), ((1.07, 1.0), 1), ((1.0, 1.0), 0)]
)
def test_the_nearest_shape_is_the_first_of_those_as_near(start, stretch, row):
    taken = StartShapes.of(start, result_mesh(start)).take_nearest(stretch)
    assert row_of(start, taken.shape) == row


def test_of_equal_larger_stretches_the_pair_counts():
    start = cap_result(small_specimen([(1.06, 1.0), (1.06, 1.05), (1.06, 1.06)]))
    start["position"] = start["position"] * np.array([1, 2, 3])[:, None, None]
    taken = StartShapes.of(start, result_mesh(start)).take_nearest((1.06, 1.045))
    assert row_of(start, taken.shape) == 1


def test_a_start_on_another_mesh_is_told(start):
    mesh = generate_mesh(replace(small_specimen(), mesh=MeshSize(0.015)))
    with pytest.raises(InputError, match="expected a result on the planar mesh of this run"):
        StartShapes.of(start, mesh)
