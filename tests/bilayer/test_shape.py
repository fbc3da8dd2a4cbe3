"""Measures against closed forms, their invariance, and their convergence with the mesh."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import cap, cone, cylinder, in_plane

from bilayer import MeshSize, generate_mesh, paper_specimen
from bilayer.measures.shape import ShapeMeasures, measure_shape, outer_radius, quality
from bilayer.measures.sphere import Sphere

R = 0.04
HEMISPHERE = math.pi / 2


def mesh_of_size(size):
    return generate_mesh(replace(paper_specimen(), mesh=MeshSize(size)))


@pytest.fixture(scope="module")
def mesh():
    return mesh_of_size(0.004)


@pytest.mark.parametrize("half_angle", [0.03, 0.1, 0.3, 0.7, 1.0, 1.3, HEMISPHERE])
def test_caps_have_the_quality_of_the_closed_form(mesh, half_angle):
    measures = measure_shape(mesh, cap(mesh.points, half_angle))
    expected = (2 * (1 - math.sin(half_angle)) + math.cos(half_angle)) / 3
    assert measures.quality == pytest.approx(expected, abs=1e-3)
    assert measures.sphere_radius == pytest.approx(R / half_angle, rel=1e-9)
    assert measures.sphere_rmse < 1e-9 * R
    assert measures.height == pytest.approx(R / half_angle * (1 - math.cos(half_angle)), rel=1e-3)


def test_the_flat_disc_is_flat(mesh):
    measures = measure_shape(mesh, in_plane(mesh.points))
    assert measures.quality == 1
    assert measures.sphere_radius > 1e6 * R
    assert measures.sphere_rmse < 1e-12
    assert measures.height < 1e-12
    assert measures.hemisphere_distance == pytest.approx(1, abs=0.002)
    assert measures.span[:2] == pytest.approx([2 * R, 2 * R], rel=1e-3)


def test_a_shape_beyond_fifty_flat_radii_is_flat(mesh):
    assert measure_shape(mesh, cap(mesh.points, 1 / 51)).quality == 1
    assert measure_shape(mesh, cap(mesh.points, 1 / 49)).quality < 1


def test_quality_is_at_most_one():
    assert quality(Sphere(radius=R, rmse=2 * R), np.zeros(3), R) == 1


def test_the_hemisphere_is_no_distance_from_itself(mesh):
    assert measure_shape(mesh, cap(mesh.points, HEMISPHERE)).hemisphere_distance < 0.005


def test_hemisphere_distance_falls_toward_the_hemisphere_and_rises_beyond(mesh):
    angles = [0.3, 0.8, 1.3, HEMISPHERE, 1.9, 2.5]
    distances = [
        measure_shape(mesh, cap(mesh.points, angle)).hemisphere_distance for angle in angles
    ]
    assert np.all(np.diff(distances)[:3] < 0)
    assert np.all(np.diff(distances)[3:] > 0)


@pytest.mark.parametrize(
    ("deformed", "expected"),
    [(lambda p: cylinder(p, math.pi / 2), 0.392), (lambda p: cone(p, math.pi / 4), 0.118)],
)
def test_what_fools_the_quality_does_not_fool_the_hemisphere_distance(mesh, deformed, expected):
    measures = measure_shape(mesh, deformed(mesh.points))
    assert measures.quality == pytest.approx(expected, abs=0.005)
    assert measures.hemisphere_distance > 1.8 * measures.quality
    assert measures.sphere_rmse / measures.sphere_radius > 0.05


@pytest.mark.parametrize(
    "deformed",
    [
        in_plane,
        lambda p: cap(p, 0.05),
        lambda p: cap(p, 1.2),
        lambda p: cylinder(p, 1.2),
        lambda p: cap(p * [1.1, 0.9], 1.0, 0.045),
    ],
)
def test_a_rigid_motion_changes_nothing(mesh, deformed):
    position = deformed(mesh.points)
    moved = Rotation.from_rotvec([0.7, -1.9, 0.4]).apply(position) + np.array([0.3, -0.2, 0.1])
    before, after = measure_shape(mesh, position), measure_shape(mesh, moved)
    assert after.quality == pytest.approx(before.quality, abs=1e-9)
    assert after.span == pytest.approx(before.span, abs=1e-9 * R)
    assert after.height == pytest.approx(before.height, abs=1e-9 * R)
    assert 1 / after.sphere_radius == pytest.approx(1 / before.sphere_radius, abs=1e-9 / R)
    assert after.hemisphere_distance == pytest.approx(before.hemisphere_distance, abs=1e-4)


def test_refinement_converges(mesh):
    shapes = [(m, cap(m.points * [1.1, 0.9], 1.0, 0.045)) for m in (mesh, mesh_of_size(0.001))]
    coarse, fine = (measure_shape(*shape) for shape in shapes)
    assert coarse.quality == pytest.approx(fine.quality, abs=2e-3)
    assert coarse.sphere_radius == pytest.approx(fine.sphere_radius, rel=2e-3)
    assert coarse.hemisphere_distance == pytest.approx(fine.hemisphere_distance, rel=0.005)


def test_outer_radius_is_that_of_the_specimen(mesh):
    assert outer_radius(mesh) == pytest.approx(R, rel=1e-12)


def test_undefined_measures_are_nan():
    undefined = ShapeMeasures.undefined()
    values = [undefined.quality, undefined.sphere_radius, undefined.height, *undefined.span]
    assert np.all(np.isnan(values))
