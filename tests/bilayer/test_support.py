"""Where a body is held."""

import numpy as np

from bilayer import generate_mesh, paper_specimen
from bilayer.support import clamped_at_centre, held_upright

MESH = generate_mesh(paper_specimen())


def arms_of(held):
    """Return the ways from the first of the held nodes to the others, m."""
    return MESH.points[list(held[1:])] - MESH.points[held[0]]


def test_a_weighted_body_is_held_by_the_neighbours_of_its_centre():
    held = clamped_at_centre(MESH.points)
    assert held[0] == MESH.centre_node
    assert any(set(held[:2]) <= set(triangle) for triangle in MESH.triangles.tolist())
    assert np.linalg.norm(arms_of(held), axis=1).max() < 1.5 * 0.003


def test_a_weightless_one_is_held_farther_out():
    held = held_upright(MESH.points)
    assert held[0] == MESH.centre_node
    assert np.abs(arms_of(held) - 0.04 / 3 * np.eye(2)).max() < 0.003


def test_the_held_nodes_span_an_angle():
    for held in (clamped_at_centre(MESH.points), held_upright(MESH.points)):
        along, across = arms_of(held)
        lengths = np.linalg.norm(along) * np.linalg.norm(across)
        assert abs(along @ across) < 0.6 * lengths
