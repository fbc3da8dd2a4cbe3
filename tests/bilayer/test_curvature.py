"""Curvatures at nodes: the sphere, the cylinder and the saddle, at the mesh's rate."""

import numpy as np
import pytest

from bilayer import MeshSize, Specimen, generate_mesh
from bilayer.geometry.curvature import curvatures
from bilayer.geometry.surface import Surface
from bilayer.specimen.layer import Layer
from bilayer.specimen.materials import NeoHookean
from bilayer.specimen.outline import Disc
from bilayer.specimen.prestretch import Prestretch

RADIUS = 0.04


def sphere(x, y):
    z = np.sqrt(4 * RADIUS**2 - x * x - y * y)
    return z, np.full_like(x, 1 / (2 * RADIUS)), np.full_like(x, 1 / (4 * RADIUS**2))


def cylinder(x, y):
    """Over x, with the radius 1.5 R."""
    return np.sqrt(2.25 * RADIUS**2 - x * x), np.full_like(x, 1 / (3 * RADIUS)), np.zeros_like(x)


def saddle(x, y):
    k = 8.0
    squared = 1 + k * k * (x * x + y * y)
    return k * x * y, k**3 * x * y / squared**1.5, -k * k / squared**2


SURFACES = {"sphere": sphere, "cylinder": cylinder, "saddle": saddle}


@pytest.fixture(scope="module")
def meshes():
    layer = Layer("film", 1e-3, NeoHookean(1e4))
    return [
        generate_mesh(Specimen(Disc(RADIUS), (layer,), Prestretch((1.0,)), MeshSize(size)))
        for size in (0.006, 0.003)
    ]


def errors(mesh, surface):
    """Rms errors of both curvatures, over 1 / R and its square."""
    x, y = mesh.points.T
    z, mean, gaussian = surface(x, y)
    found = curvatures(Surface(np.column_stack([x, y, z]), mesh.triangles))
    scale = 1 / RADIUS
    return (
        np.sqrt(np.mean((found.mean - mean) ** 2)) / scale,
        np.sqrt(np.mean((found.gaussian - gaussian) ** 2)) / scale**2,
    )


@pytest.mark.parametrize("name", SURFACES)
def test_curvatures_converge_at_the_mesh_s_rate(meshes, name):
    coarse, fine = (np.array(errors(mesh, SURFACES[name])) for mesh in meshes)
    assert (fine < 1.2e-3).all()
    rate = np.log2(coarse / fine) / np.log2(np.sqrt(len(meshes[1].points) / len(meshes[0].points)))
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
