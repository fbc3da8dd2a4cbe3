"""The distance to the hemisphere: its parts against closed forms and exhaustive search."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad, quad
from scipy.spatial.transform import Rotation
from shapes import cylinder

from bilayer import generate_mesh, paper_specimen
from bilayer.geometry.nearest_point import NearestPoint, distance_to_triangles
from bilayer.geometry.surface import Surface
from bilayer.measures.hemisphere import (
    flat_disc_distance,
    unit_hemisphere_samples,
    vectors_from_unit_hemisphere,
)


def test_nearest_point_of_the_hemisphere_is_the_nearest_of_many():
    queries = np.random.default_rng(1).uniform(-1.5, 1.5, (200, 3))
    many = unit_hemisphere_samples(50_000)
    rim = np.linspace(0, 2 * math.pi, 2000)
    many = np.concatenate([many, np.column_stack([np.cos(rim), np.sin(rim), 0 * rim])])
    nearest = [np.linalg.norm(many - query, axis=1).min() for query in queries]
    away = vectors_from_unit_hemisphere(queries)
    assert np.linalg.norm(away, axis=1) == pytest.approx(nearest, abs=5e-3)
    on_it = queries - away
    assert np.linalg.norm(on_it, axis=1) == pytest.approx(1, abs=1e-12)
    assert np.all(on_it[:, 2] >= 0)


def test_the_pole_is_as_near_to_the_centre_as_any_other_point():
    assert vectors_from_unit_hemisphere(np.zeros((1, 3))).tolist() == [[0, 0, -1]]


def test_samples_of_the_hemisphere_stand_for_equal_areas():
    samples = unit_hemisphere_samples(2000)
    assert np.linalg.norm(samples, axis=1) == pytest.approx(1)
    assert samples.mean(axis=0) == pytest.approx([0, 0, 0.5], abs=1e-3)
    assert samples.T @ samples / 2000 == pytest.approx(np.eye(3) / 3, abs=1e-3)


def test_distance_of_the_flat_disc_against_quadrature():
    a = 2 / math.pi

    def mean_square(z):
        from_disc = quad(lambda r: 2 * r * (math.hypot(r, z) - a) ** 2, 0, 1)[0]
        from_cap = dblquad(lambda t, f: (a * math.cos(t) - z) ** 2 * math.sin(t) / (2 * math.pi),
                           0, 2 * math.pi, 0, math.pi / 2)[0]  # fmt: skip
        return (from_disc + from_cap) / 2

    least = min(mean_square(z) for z in np.linspace(0, a, 201))
    assert flat_disc_distance(0.04) == pytest.approx(0.04 * math.sqrt(least), rel=1e-4)


def test_distance_to_a_triangle_in_each_of_its_regions():
    triangle = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    points = np.array([[0.5, 0.5, 3], [1, -1, 0], [-3, -4, 0], [2, 2, 0], [3, -1, 1], [0, 0, 0]])
    expected = [3, 1, 5, math.sqrt(2), math.sqrt(3), 0]
    assert distance_to_triangles(points, np.broadcast_to(triangle, (6, 3, 3))) == pytest.approx(
        expected
    )


def test_nearest_point_finds_what_exhaustive_search_finds():
    mesh = generate_mesh(paper_specimen())
    surface = Surface(cylinder(mesh.points, 2.0), mesh.triangles)
    queries = Rotation.from_rotvec([0.3, 0.2, 0.0]).apply(unit_hemisphere_samples(300)) * 0.025
    corners = np.broadcast_to(surface.corners, (len(queries), *surface.corners.shape))
    exhaustive = distance_to_triangles(queries[:, None], corners).min(axis=1)
    found = np.linalg.norm(NearestPoint(surface).vectors_to(queries), axis=1)
    assert np.all(found >= exhaustive - 1e-15)
    assert found == pytest.approx(exhaustive, abs=2e-5)
