"""Measures against closed forms, their invariance, and their convergence with the mesh."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from shapes import cap, cone, cylinder, in_plane

from bilayer import MeshSize, PlanarMesh, generate_mesh, paper_specimen
from bilayer.measures.shape import ShapeMeasures, measure_shape, quality
from bilayer.measures.sphere import Sphere
from bilayer.specimen.outline import Ellipse, Rectangle

R = 0.04
HEMISPHERE = math.pi / 2


def mesh_of_size(size):
    return generate_mesh(replace(paper_specimen(), mesh=MeshSize(size)))


@pytest.fixture(scope="module")
def mesh():
    return mesh_of_size(0.004)


@pytest.mark.parametrize("half_angle", [0.03, 0.1, 0.3, 0.7, 1.0, 1.3, HEMISPHERE])
def test_caps_have_the_quality_of_the_closed_form(mesh, half_angle):
    measures = measure_shape(mesh, cap(mesh.points, half_angle), R)
    expected = (2 * (1 - math.sin(half_angle)) + math.cos(half_angle)) / 3
    assert measures.quality == pytest.approx(expected, abs=1e-3)
    assert measures.sphere_radius == pytest.approx(R / half_angle, rel=1e-9)
    assert measures.sphere_rmse < 1e-9 * R
    assert measures.height == pytest.approx(R / half_angle * (1 - math.cos(half_angle)), rel=1e-3)


def test_the_flat_disc_is_flat(mesh):
    measures = measure_shape(mesh, in_plane(mesh.points), R)
    assert measures.quality == 1
    assert measures.sphere_radius > 1e6 * R
    assert measures.sphere_rmse < 1e-12
    assert measures.height < 1e-12
    assert measures.hemisphere_distance == pytest.approx(1, abs=0.002)
    assert measures.span[:2] == pytest.approx([2 * R, 2 * R], rel=1e-3)


def test_a_shape_beyond_fifty_flat_radii_is_flat(mesh):
    assert measure_shape(mesh, cap(mesh.points, 1 / 51), R).quality == 1
    assert measure_shape(mesh, cap(mesh.points, 1 / 49), R).quality < 1


def test_quality_is_at_most_one():
    assert quality(Sphere(radius=R, rmse=2 * R, distances=np.zeros(3)), np.zeros(3), R) == 1


def test_the_hemisphere_is_no_distance_from_itself(mesh):
    assert measure_shape(mesh, cap(mesh.points, HEMISPHERE), R).hemisphere_distance < 0.005


def test_hemisphere_distance_falls_toward_the_hemisphere_and_rises_beyond(mesh):
    angles = [0.3, 0.8, 1.3, HEMISPHERE, 1.9, 2.5]
    distances = [
        measure_shape(mesh, cap(mesh.points, angle), R).hemisphere_distance for angle in angles
    ]
    assert np.all(np.diff(distances)[:3] < 0)
    assert np.all(np.diff(distances)[3:] > 0)


@pytest.mark.parametrize(
    ("deformed", "expected"),
    [(lambda p: cylinder(p, math.pi / 2), 0.392), (lambda p: cone(p, math.pi / 4), 0.118)],
)
def test_what_fools_the_quality_does_not_fool_the_hemisphere_distance(mesh, deformed, expected):
    measures = measure_shape(mesh, deformed(mesh.points), R)
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
    before, after = measure_shape(mesh, position, R), measure_shape(mesh, moved, R)
    assert after.quality == pytest.approx(before.quality, abs=1e-9)
    assert after.span == pytest.approx(before.span, abs=1e-9 * R)
    assert after.height == pytest.approx(before.height, abs=1e-9 * R)
    assert 1 / after.sphere_radius == pytest.approx(1 / before.sphere_radius, abs=1e-9 / R)
    assert after.hemisphere_distance == pytest.approx(before.hemisphere_distance, abs=1e-4)


def test_refinement_converges(mesh):
    shapes = [(m, cap(m.points * [1.1, 0.9], 1.0, 0.045)) for m in (mesh, mesh_of_size(0.001))]
    coarse, fine = (measure_shape(*shape, R) for shape in shapes)
    assert coarse.quality == pytest.approx(fine.quality, abs=2e-3)
    assert coarse.sphere_radius == pytest.approx(fine.sphere_radius, rel=2e-3)
    assert coarse.hemisphere_distance == pytest.approx(fine.hemisphere_distance, rel=0.005)


def test_a_sheet_with_a_hole_stands_on_its_outer_rim():
    """Its inner rim is tilted against the outer one; measured on both, it would be higher."""
    ring = ring_mesh(0.3, 1.0)
    radius = np.linalg.norm(ring.points, axis=1)
    height = 0.3 * (1 - radius) * (1 + ring.points[:, 0] / radius)
    measures = measure_shape(ring, np.column_stack([ring.points, height]), 1.0)
    assert measures.span[:2] == pytest.approx([2.0, 2.0], rel=0.01)
    assert measures.height == pytest.approx(height.max(), rel=1e-9)


def ring_mesh(inner, outer, around=48, across=6):
    """Return a flat ring, its triangles in rows around the origin."""
    angle, radius = np.meshgrid(
        2 * np.pi * np.arange(around) / around, np.linspace(inner, outer, across + 1)
    )
    points = np.column_stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()])
    here = np.arange(around * across).reshape(across, around)
    beside, out = np.roll(here, -1, axis=1), here + around
    corner = beside + around
    triangles = np.concatenate([[here, out, corner], [here, corner, beside]], axis=2)
    triangles = triangles.transpose(1, 2, 0).reshape(-1, 3)
    return PlanarMesh(points, triangles, np.zeros(len(triangles), dtype=int))


@pytest.mark.parametrize("outline", [Rectangle(0.06, 0.06), Ellipse(0.07, 0.055)])
def test_a_flat_sheet_of_any_outline_is_as_far_from_its_hemisphere(outline):
    """It is 1 for a disc."""
    sheet = replace(paper_specimen().with_layer("kirigami", pattern=None), outline=outline)
    mesh = generate_mesh(sheet)
    measures = measure_shape(mesh, in_plane(mesh.points), sheet.characteristic_length)
    assert measures.hemisphere_distance == pytest.approx(1, abs=0.1)


def test_undefined_measures_are_nan():
    undefined = ShapeMeasures.undefined()
    values = [undefined.quality, undefined.sphere_radius, undefined.height, *undefined.span]
    assert np.all(np.isnan(values))
