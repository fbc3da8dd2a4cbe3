"""The body frame: toward the apex, along the first strip, unmoved by a tilt."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import cap, cylinder, in_plane

from bilayer import generate_mesh, paper_specimen
from bilayer.measures.body_frame import body_frame

TURN = Rotation.from_rotvec([0.4, 0.3, 1.1])


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(paper_specimen())


@pytest.mark.parametrize("deformed", [in_plane, lambda p: cap(p, 1.0), lambda p: cylinder(p, 1.0)])
def test_axes_turn_with_the_body(mesh, deformed):
    turned = body_frame(mesh, TURN.apply(deformed(mesh.points)) + 1.0)
    assert turned.axes == pytest.approx(TURN.apply(np.eye(3)), abs=1e-3)
    assert turned.axes @ turned.axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(turned.axes) == pytest.approx(1)


def test_a_dome_that_popped_the_other_way_has_its_apex_up(mesh):
    bowl = cap(mesh.points, 1.0) * [1, 1, -1]
    frame = body_frame(mesh, bowl)
    assert frame.axes[2] == pytest.approx([0, 0, -1], abs=1e-4)
    assert frame.coordinates(bowl)[mesh.centre_node, 2] > 0
    assert frame.axes[0] == pytest.approx([1, 0, 0], abs=1e-4)


def test_a_flat_body_has_the_kirigami_side_up(mesh):
    upside_down = Rotation.from_rotvec([math.pi, 0, 0]).apply(in_plane(mesh.points))
    assert body_frame(mesh, upside_down).axes[2] == pytest.approx([0, 0, -1])


def test_a_tilt_does_not_change_the_height(mesh):
    dome = cap(mesh.points, 1.0)
    tilted = Rotation.from_rotvec([0.2, 0.0, 0.0]).apply(dome)
    height = body_frame(mesh, dome).span(dome)[2]
    assert body_frame(mesh, tilted).span(tilted)[2] == pytest.approx(height, rel=1e-12)
    assert np.ptp(tilted[:, 2]) > 1.05 * height
