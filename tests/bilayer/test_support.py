"""The choice of the held nodes."""

import numpy as np
import pytest
from grids import frame, grid_mesh, rectangle

from bilayer import InputError, generate_mesh, paper_specimen
from bilayer.specimen.support import choose_held_nodes, choose_nodes_at_centre, choose_nodes_inside


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(paper_specimen())


def arms_of(mesh, held):
    """Return the ways from the first of the held nodes to the others, m."""
    return mesh.points[list(held[1:])] - mesh.points[held[0]]


def test_a_weighted_body_is_held_by_the_neighbours_of_its_centre(mesh):
    held = choose_nodes_at_centre(mesh.points)
    assert held[0] == mesh.centre_node
    assert any(set(held[:2]) <= set(triangle) for triangle in mesh.triangles.tolist())
    assert np.linalg.norm(arms_of(mesh, held), axis=1).max() < 1.5 * 0.003


def test_a_weightless_one_is_held_farther_out(mesh):
    held = choose_nodes_inside(mesh.points)
    assert held[0] == mesh.centre_node
    assert np.abs(arms_of(mesh, held) - 0.04 / 3 * np.eye(2)).max() < 0.003


def test_the_held_nodes_span_an_angle(mesh):
    for held in (choose_nodes_at_centre(mesh.points), choose_nodes_inside(mesh.points)):
        along, across = arms_of(mesh, held)
        lengths = np.linalg.norm(along) * np.linalg.norm(across)
        assert abs(along @ across) < 0.6 * lengths


SHEETS = {
    "ring": grid_mesh(frame(9, 9), 0.01, (-0.045, -0.045)),
    "corner": grid_mesh([*rectangle(9, 2), *((x, y) for x, y in rectangle(2, 9) if y > 1)]),
    "strip": grid_mesh(rectangle(2, 40), 0.01, (3.0, -7.0)),
    "one row": grid_mesh(rectangle(40, 1)),
    "one cell": grid_mesh([(0, 0)]),
}


@pytest.mark.parametrize("sheet", SHEETS.values(), ids=SHEETS)
@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize("angle", [0.0, 0.5, 0.8, 1.2, 2.5])
def test_any_sheet_is_held_about_its_centre_by_nodes_that_span_an_angle(sheet, gravity, angle):
    c, s = np.cos(angle), np.sin(angle)
    mesh = sheet.with_points(sheet.points @ [[c, s], [-s, c]])
    held = choose_held_nodes(mesh.points, gravity, mesh.centroid)
    along, across = arms_of(mesh, held)
    distance = np.linalg.norm(mesh.points - mesh.centroid, axis=1)
    assert distance[held[0]] == pytest.approx(distance.min())
    height = abs(along[0] * across[1] - along[1] * across[0]) / np.linalg.norm(along)
    assert height > 0.5 * np.sqrt(mesh.areas.max())


def test_points_on_a_line_are_refused():
    with pytest.raises(InputError, match="points: all lie on a line, expected a sheet"):
        choose_held_nodes(np.array([[0.0, 0.0], [1.0, 2.0], [2.0, 4.0]]), 0.0)
