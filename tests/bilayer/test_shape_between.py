"""Shapes between two: sides keep their lengths if the sheet is rolled."""

import numpy as np
import pytest
from grids import grid_mesh, rectangle

from bilayer.geometry.shape_between import ShapesBetween

GRID = grid_mesh(rectangle(8, 8), size=0.01, origin=(-0.04, -0.04))


def rolled(curvature):
    x, y = GRID.points.T
    return np.column_stack(
        [np.sin(curvature * x) / curvature, y, (1 - np.cos(curvature * x)) / curvature]
    )


def sides(shape):
    return np.linalg.norm(shape[GRID.edges[:, 1]] - shape[GRID.edges[:, 0]], axis=1)


def test_the_ends_are_the_shapes():
    first, second = rolled(10.0), rolled(-30.0)
    between = ShapesBetween(first, second, GRID.triangles)
    assert between.at(0.0) == pytest.approx(first, abs=1e-12)
    assert between.at(1.0) == pytest.approx(second, abs=1e-12)


def test_a_rolled_sheet_turned_over_keeps_its_sides_on_the_way():
    between = ShapesBetween(rolled(30.0), rolled(-30.0), GRID.triangles).at(0.5)
    assert sides(between) == pytest.approx(sides(rolled(30.0)), rel=0.02)
    assert np.ptp(between[:, 2]) < 1e-9  # flat half way
    straight = (rolled(30.0) + rolled(-30.0)) / 2
    assert sides(straight).min() < 0.6 * sides(rolled(30.0)).min()  # the nodes' own way presses it


def test_a_turn_is_shared():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])  # a quarter turn about z
    half = ShapesBetween(rolled(10.0), rolled(10.0) @ turn.T, GRID.triangles).at(0.5)
    assert sides(half) == pytest.approx(sides(rolled(10.0)), rel=1e-9)
