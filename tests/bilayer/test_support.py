"""Where a body is held."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import CutPattern, MeshSize, PlanarMesh, generate_mesh, paper_specimen
from bilayer.specimen.support import clamped_at_centre, held_upright

AWAY = np.array([0.3, -0.2])


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(paper_specimen())


def arms_of(mesh, held):
    """Return the ways from the first of the held nodes to the others, m."""
    return mesh.points[list(held[1:])] - mesh.points[held[0]]


def test_a_weighted_body_is_held_by_the_neighbours_of_its_centre(mesh):
    held = clamped_at_centre(mesh.points, mesh.centroid)
    assert held[0] == mesh.centre_node
    assert any(set(held[:2]) <= set(triangle) for triangle in mesh.triangles.tolist())
    assert np.linalg.norm(arms_of(mesh, held), axis=1).max() < 1.5 * 0.003


def test_a_weightless_one_is_held_farther_out(mesh):
    held = held_upright(mesh.points, mesh.centroid)
    assert held[0] == mesh.centre_node
    assert np.abs(arms_of(mesh, held) - 0.04 / 3 * np.eye(2)).max() < 0.003


def sheets(mesh):
    """The disc, moved away, drawn out, with a hole, as a frame of two beams, and the hole moved."""
    with_hole = without_nodes(mesh, np.linalg.norm(mesh.points, axis=1) < 0.02)
    above, beside = mesh.points[:, 1] > -0.01, mesh.points[:, 0] > -0.01
    return {
        "disc": mesh,
        "elsewhere": mesh.with_points(mesh.points + AWAY),
        "strip": mesh.with_points(mesh.points * [0.02, 1.0]),
        "ring": with_hole,
        "thin ring": without_nodes(mesh, np.linalg.norm(mesh.points, axis=1) < 0.03),
        "ring elsewhere": with_hole.with_points(with_hole.points + AWAY),
        "angle": without_nodes(mesh, above & beside),
    }


def without_nodes(mesh, left_out):
    """Return the triangles without any node of some."""
    kept = mesh.triangles[~left_out[mesh.triangles].any(axis=1)]
    used, triangles = np.unique(kept, return_inverse=True)
    return PlanarMesh(mesh.points[used], triangles.reshape(-1, 3), np.ones(len(kept)))


SHAPES = ("disc", "elsewhere", "strip", "ring", "thin ring", "ring elsewhere", "angle")


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("choose", [clamped_at_centre, held_upright])
def test_what_is_held_takes_the_rigid_motion_away(mesh, choose, shape):
    """The second node lies along x from the first, the third off their line."""
    sheet = sheets(mesh)[shape]
    along, across = arms_of(sheet, choose(sheet.points, sheet.centroid))
    assert abs(along[0]) > 0.2 * np.linalg.norm(along)
    lengths = np.linalg.norm(along) * np.linalg.norm(across)
    assert abs(along[0] * across[1] - along[1] * across[0]) > 0.2 * lengths


def test_a_ring_is_held_around_its_hole(mesh):
    ring = sheets(mesh)["ring elsewhere"]
    for choose in (clamped_at_centre, held_upright):
        held = ring.points[list(choose(ring.points, ring.centroid))] - AWAY
        assert held == pytest.approx(0.02 * np.array([[-1, 0], [1, 0], [0, 1]]), abs=0.003)


def test_a_disc_is_held_at_its_middle_wherever_it_lies(mesh):
    moved = sheets(mesh)["elsewhere"]
    for choose in (clamped_at_centre, held_upright):
        assert choose(moved.points, moved.centroid) == choose(mesh.points, np.zeros(2))


@pytest.mark.parametrize("strips", range(1, 9))
@pytest.mark.parametrize("size", [0.003, 0.006, 0.016])
def test_the_nodes_of_discs_are_those_nearest_to_the_origin(strips, size):
    """That the centre of the area is not the origin to the last digit changes nothing."""
    cut = CutPattern(strips, 0.008, 0.3)
    disc = replace(paper_specimen().with_layer("kirigami", pattern=cut), mesh=MeshSize(size))
    mesh = generate_mesh(disc)
    for choose in (clamped_at_centre, held_upright):
        assert choose(mesh.points, mesh.centroid) == choose(mesh.points, np.zeros(2))
        arms = mesh.points - mesh.points[choose(mesh.points, np.zeros(2))[0]]
        reach = {clamped_at_centre: np.partition(np.linalg.norm(arms, axis=1), 1)[1],
                 held_upright: np.linalg.norm(arms, axis=1).max() / 3}[choose]  # fmt: skip
        for node, place in zip(
            choose(mesh.points, np.zeros(2)), [(0, 0), (reach, 0), (0, reach)], strict=True
        ):
            assert node == np.argmin(np.linalg.norm(arms - place, axis=1))
