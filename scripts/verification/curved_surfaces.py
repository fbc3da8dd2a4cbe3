"""Curvatures at the nodes of surfaces whose curvature is known. SI units."""

import numpy as np

from bilayer import MeshSize, PlanarMesh, Specimen, generate_mesh
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


def disc_meshes() -> list[PlanarMesh]:
    """Discs with edges of 6 and 3 mm."""
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


def errors_and_rates(name: str, meshes: list[PlanarMesh]):
    """Errors of both curvatures on the finer mesh, and the powers of the edge they fall with."""
    coarse, fine = (np.array(errors(mesh, SURFACES[name])) for mesh in meshes)
    finer = np.sqrt(len(meshes[1].points) / len(meshes[0].points))
    return fine, np.log2(coarse / fine) / np.log2(finer)
