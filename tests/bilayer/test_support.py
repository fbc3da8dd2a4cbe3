"""Where a body is held."""

import numpy as np
import pytest

from bilayer import generate_mesh, paper_specimen
from bilayer.specimen.support import clamped_at_centre, held_upright


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(paper_specimen())


def arms_of(mesh, held):
    """Return the ways from the first of the held nodes to the others, m."""
    return mesh.points[list(held[1:])] - mesh.points[held[0]]


def test_a_weighted_body_is_held_by_the_neighbours_of_its_centre(mesh):
    held = clamped_at_centre(mesh.points)
    assert held[0] == mesh.centre_node
    assert any(set(held[:2]) <= set(triangle) for triangle in mesh.triangles.tolist())
    assert np.linalg.norm(arms_of(mesh, held), axis=1).max() < 1.5 * 0.003


def test_a_weightless_one_is_held_farther_out(mesh):
    held = held_upright(mesh.points)
    assert held[0] == mesh.centre_node
    assert np.abs(arms_of(mesh, held) - 0.04 / 3 * np.eye(2)).max() < 0.003


def test_the_held_nodes_span_an_angle(mesh):
    for held in (clamped_at_centre(mesh.points), held_upright(mesh.points)):
        along, across = arms_of(mesh, held)
        lengths = np.linalg.norm(along) * np.linalg.norm(across)
        assert abs(along @ across) < 0.6 * lengths
