"""What a lattice of hinges answers to curvature (ladder, rung 9).

Energy per area of an equilateral lattice whose every hinge costs k theta^2 / 2, bent to a
curvature k0: sqrt(3)/4, 1/sqrt(3), 2/sqrt(3) times k k0^2 for a cylinder, a sphere, a saddle. With
k = 2/sqrt(3) D a plate has 1/2, 1 + nu, 1 - nu times D k0^2: no nu fits the last two.
"""

import numpy as np
import pytest

from dshell.hinges import Hinges, hinge_angles
from dshell.topology import Topology

EDGE = 1e-3  # m
CURVATURE = 2.0  # 1/m; times the patch's size 0.024: small tilts
RINGS = 12
STIFFNESS = 0.7  # J


def hexagonal_patch():
    """Points and triangles of a hexagon of equilateral triangles."""
    span = range(-RINGS, RINGS + 1)
    inside = [(i, j) for i in span for j in span if abs(i + j) <= RINGS]
    number = {key: row for row, key in enumerate(inside)}
    points = EDGE * np.array([(i + j / 2, j * np.sqrt(3) / 2) for i, j in inside])
    up = [((i, j), (i + 1, j), (i, j + 1)) for i, j in inside]
    down = [((i + 1, j), (i + 1, j + 1), (i, j + 1)) for i in span for j in span]
    whole = [t for t in up + down if all(key in number for key in t)]
    return points, np.array([[number[key] for key in t] for t in whole])


def cylinder(x, y):
    turn = CURVATURE * x
    return np.column_stack([np.sin(turn) / CURVATURE, y, (np.cos(turn) - 1) / CURVATURE])


def sphere(x, y):
    return np.column_stack([x, y, -CURVATURE / 2 * (x**2 + y**2)])


def saddle(x, y):
    return np.column_stack([x, y, -CURVATURE / 2 * (x**2 - y**2)])


@pytest.mark.parametrize(
    ("bent", "factor"),
    [(cylinder, np.sqrt(3) / 4), (sphere, 1 / np.sqrt(3)), (saddle, 2 / np.sqrt(3))],
)
def test_energy_per_area(bent, factor):
    points, triangles = hexagonal_patch()
    nodes = Topology.of(triangles).hinges
    lattice = Hinges(nodes, np.full(len(nodes), STIFFNESS), np.zeros(len(nodes)))
    energy = lattice.energy(bent(*points.T)[nodes]).sum()
    area = len(nodes) * EDGE**2 / (2 * np.sqrt(3))  # of each hinge: a third of each triangle
    assert energy / area == pytest.approx(factor * STIFFNESS * CURVATURE**2, rel=3e-3)


def test_natural_dihedral_of_a_sphere():
    points, triangles = hexagonal_patch()
    angles = hinge_angles(sphere(*points.T)[Topology.of(triangles).hinges])
    assert angles == pytest.approx(CURVATURE * EDGE / np.sqrt(3), rel=3e-3)
