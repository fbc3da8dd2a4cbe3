"""Curvatures at nodes: the sphere, the cylinder and the saddle, at the mesh's rate."""

import numpy as np
import pytest
from verification.curved_surfaces import RADIUS, SURFACES, disc_meshes, errors_and_rates, sphere

from bilayer.geometry.curvature import curvatures
from bilayer.geometry.surface import Surface


@pytest.fixture(scope="module")
def meshes():
    return disc_meshes()


@pytest.mark.parametrize("name", SURFACES)
def test_curvatures_converge_at_the_mesh_s_rate(meshes, name):
    error, rate = errors_and_rates(name, meshes)
    assert (error < 1.2e-3).all()
    assert (rate > 0.95).all()  # of the edge length; 2 on the sphere and the cylinder
    if name != "saddle":
        assert (rate > 1.9).all()


def test_normals_of_a_sphere_and_the_sense_of_the_curvature(meshes):
    x, y = meshes[1].points.T
    z = sphere(x, y)[0]
    points = np.column_stack([x, y, z])
    found = curvatures(Surface(points, meshes[1].triangles))
    away = np.linalg.norm(found.normal - points / (2 * RADIUS), axis=1)
    assert away.max() < 1e-3
    below = curvatures(Surface(points * [1, 1, -1], meshes[1].triangles))
    assert below.mean == pytest.approx(-found.mean, rel=1e-6)
    assert below.gaussian == pytest.approx(found.gaussian, rel=1e-6)


def test_nodes_without_enough_others_have_no_curvature():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]])
    found = curvatures(Surface(points, np.array([[0, 1, 2]])))
    assert np.isnan(found.mean).all() and np.isnan(found.gaussian).all()
