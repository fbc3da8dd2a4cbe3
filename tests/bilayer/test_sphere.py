"""The best sphere: exact on spheres, a plane when flat, the least sum of squares otherwise."""

import math

import numpy as np
import pytest
from scipy.optimize import approx_fprime, minimize
from shapes import cap, cone, in_plane

from bilayer import generate_mesh, paper_specimen
from bilayer.geometry.surface import Surface
from bilayer.measures.sphere import _distance, _distance_slopes, fit_sphere


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(paper_specimen())


@pytest.mark.parametrize("half_angle", [1e-5, 1e-3, 0.1, 1.0, 2.0, 3.1])
@pytest.mark.parametrize("side", [1, -1])
def test_caps_of_any_depth_to_either_side(mesh, half_angle, side):
    sphere = fit_sphere(Surface(cap(mesh.points, half_angle) * [1, 1, side], mesh.triangles))
    assert sphere.radius == pytest.approx(0.04 / half_angle, rel=1e-6)
    assert sphere.rmse < 1e-12


def test_an_exact_plane_has_no_error(mesh):
    sphere = fit_sphere(Surface(in_plane(mesh.points), mesh.triangles))
    assert sphere.radius > 1e9
    assert sphere.rmse < 1e-15


def test_a_wrinkled_plane_has_the_rms_of_its_wrinkles(mesh):
    wrinkled = in_plane(mesh.points)
    wrinkled[:, 2] = 1e-4 * np.cos(8 * np.arctan2(wrinkled[:, 1], wrinkled[:, 0]))
    surface = Surface(wrinkled, mesh.triangles)
    weights = surface.node_areas / surface.node_areas.sum()
    assert fit_sphere(surface).rmse == pytest.approx(
        math.sqrt(weights @ wrinkled[:, 2] ** 2), rel=1e-2
    )


def test_no_sphere_fits_a_cone_better(mesh):
    surface = Surface(cone(mesh.points, 0.9), mesh.triangles)
    weights = surface.node_areas / surface.node_areas.sum()

    def mean_square(sphere):  # centre and radius in units of the disc, where it is well posed
        distance = np.linalg.norm(surface.points / 0.04 - sphere[:3], axis=1) - sphere[3]
        return weights @ distance**2

    other = minimize(mean_square, [0, 0, -0.5, 0.7], method="Nelder-Mead",
                     options={"xatol": 1e-9, "fatol": 1e-16, "maxiter": 4000})  # fmt: skip
    sphere = fit_sphere(surface)
    assert sphere.radius == pytest.approx(0.04 * other.x[3], rel=1e-5)
    assert sphere.rmse == pytest.approx(0.04 * math.sqrt(other.fun), rel=1e-6)


def test_triangles_count_by_their_area_not_by_their_number(mesh):
    """Refining one side of a shape, which is not a sphere, must not pull the fit toward it."""
    bumpy = cone(mesh.points, 0.9)
    fine_side = np.flatnonzero(mesh.points[mesh.triangles].mean(axis=1)[:, 0] > 0)
    a, b, c = mesh.triangles[fine_side].T
    centres = len(bumpy) + np.arange(len(fine_side))
    triangles = np.concatenate(
        [
            np.delete(mesh.triangles, fine_side, axis=0),
            np.column_stack([a, b, centres]),
            np.column_stack([b, c, centres]),
            np.column_stack([c, a, centres]),
        ]
    )
    points = np.concatenate([bumpy, bumpy[mesh.triangles[fine_side]].mean(axis=1)])
    even = fit_sphere(Surface(bumpy, mesh.triangles))
    uneven = fit_sphere(Surface(points, triangles))
    assert uneven.radius == pytest.approx(even.radius, rel=0.01)


@pytest.mark.parametrize("curvature", [0.0, 0.3, -0.8])
def test_slopes_of_the_distance_against_differences(curvature):
    points = np.random.default_rng(0).normal(size=(5, 3))
    unknowns = np.array([curvature, 0.2, 0.1, -0.3])
    differences = approx_fprime(unknowns, lambda u: _distance(points, *u), 1e-7)
    assert _distance_slopes(points, *unknowns) == pytest.approx(differences, abs=1e-5)
