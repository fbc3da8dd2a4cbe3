"""The shapes of a start that lead to the milestones of a run, in whatever order they come."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from made_results import cap_result, small_specimen

from bilayer import InputError, MeshSize, generate_mesh
from bilayer.results.schema import result_mesh
from bilayer.results.start_shapes import StartShapes
from bilayer.results.starting import starting_shape, with_waypoints

UP_AND_DOWN = [1.03, 1.06, 1.03, 1.06]


@pytest.fixture(scope="module")
def start():
    """A result that goes up and down; no two of its shapes are alike."""
    result = cap_result(small_specimen(UP_AND_DOWN))
    result["position"] = result["position"] * np.array([1, 1.1, 1.2, 1.3])[:, None, None]
    return result


def take_along(start, targets):
    """The rows of a start whose shapes lead to each target, and how far they are from it."""
    positions, shapes = start["position"].values, StartShapes.of(start, result_mesh(start))
    pairs = [(x, x) for x in (1.0, *targets)]
    ways = [shapes.take_shapes(*way) for way in itertools.pairwise(pairs)]
    rows = [
        [[np.array_equal(s.shape, row) for row in positions].index(True) for s in way]
        for way in ways
    ]
    return rows, [[shape.remaining for shape in way] for way in ways]


def test_a_prestretch_that_comes_again_has_its_own_shape(start):
    rows, remaining = take_along(start, UP_AND_DOWN)
    assert rows == [[0], [1], [2], [3]]
    assert remaining == [[0]] * 4


def test_waypoints_lie_on_the_way_down_too():
    specimen = with_waypoints(small_specimen([1.1, 1.01, 1.1]))
    assert specimen.prestretch.nominal == pytest.approx([1.05, 1.1, 1.055, 1.01, 1.055, 1.1])
    start = cap_result(specimen)
    start["position"] = start["position"] * np.linspace(1, 2, 6)[:, None, None]
    rows, remaining = take_along(start, [1.1, 1.01, 1.1])
    assert rows == [[0, 1], [2, 3], [4, 5]]
    assert np.concatenate(remaining) == pytest.approx([0.05, 0, 0.045, 0, 0.045, 0])


@pytest.mark.parametrize(
    ("stretch", "row"), [((1.031, 1.031), 0), ((1.07, 1.0), 1), ((1.0, 1.0), 0)]
)
def test_the_nearest_shape_is_the_first_of_those_as_near(start, stretch, row):
    shape = starting_shape(start, result_mesh(start), stretch)
    assert np.array_equal(shape, start["position"].values[row])


def test_of_equal_larger_stretches_the_pair_counts():
    start = cap_result(small_specimen([(1.06, 1.0), (1.06, 1.05), (1.06, 1.06)]))
    start["position"] = start["position"] * np.array([1, 2, 3])[:, None, None]
    shape = starting_shape(start, result_mesh(start), (1.06, 1.045))
    assert np.array_equal(shape, start["position"].values[1])


def test_a_start_on_another_mesh_is_told(start):
    mesh = generate_mesh(replace(small_specimen(), mesh=MeshSize(0.015)))
    with pytest.raises(InputError, match="expected a result on the planar mesh of this run"):
        starting_shape(start, mesh, (1.0, 1.0))
