"""The angles by which a surface turns over its edges."""

import numpy as np
from grids import grid_mesh, rectangle

from bilayer.geometry.surface import Surface
from bilayer.geometry.turns import turns_over_edges

COLUMNS, ROWS, TURN = 6, 2, 0.3


def test_a_prism_turns_over_its_rulings_alone():
    """Cells of a prism's sides: the rulings between two columns turn, nothing else does."""
    mesh = grid_mesh(rectangle(COLUMNS, ROWS))
    x, y = mesh.points.T
    radius = 0.5 / np.sin(TURN / 2)  # of the circle through the corners, the sides being 1
    shape = np.column_stack([radius * np.sin(TURN * x), y, radius * np.cos(TURN * x)])
    turns = turns_over_edges(Surface(shape, mesh.triangles))
    assert len(turns) == len(mesh.edges) - len(mesh.boundary_edges)
    rulings = (COLUMNS - 1) * ROWS
    expected = np.sort(np.append(np.zeros(len(turns) - rulings), np.full(rulings, TURN)))
    np.testing.assert_allclose(np.sort(turns), expected, atol=1e-7)


def test_a_sheet_folded_back_on_itself_turns_by_a_half_turn():
    points = np.array([[0.0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]])
    turns = turns_over_edges(Surface(points, np.array([[0, 2, 1], [0, 1, 3]])))
    np.testing.assert_allclose(turns, [np.pi])
