"""The bending energy of an equilateral lattice of hinges.

Every hinge costs k theta^2 / 2. With k = 2/sqrt(3) D a plate has 1/2, 1 + nu, 1 - nu times D k0^2
for a cylinder, a sphere and a saddle of curvature k0: no nu fits the lattice's last two.
"""

import numpy as np

from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges, hinge_angles
from dshell.energies.topology import Topology
from verification.meshes import hexagon

EDGE = 1e-3  # m
CURVATURE = 2.0  # 1/m; times the patch's size 0.024: small tilts
RINGS = 12
STIFFNESS = 0.7  # J


def cylinder(x, y):
    turn = CURVATURE * x
    return np.column_stack([np.sin(turn) / CURVATURE, y, (np.cos(turn) - 1) / CURVATURE])


def sphere(x, y):
    return np.column_stack([x, y, -CURVATURE / 2 * (x**2 + y**2)])


def saddle(x, y):
    return np.column_stack([x, y, -CURVATURE / 2 * (x**2 - y**2)])


def lattice_energy(bent) -> float:
    """Energy per area of the lattice bent to a surface, over k k0^2."""
    mesh = hexagon(RINGS, EDGE)
    nodes = Topology.of(mesh.triangles).hinges
    lattice = Hinges(nodes, np.full(len(nodes), STIFFNESS), np.zeros(len(nodes)))
    energy = lattice.at(bent(*mesh.points.T).reshape(-1)).energy().sum()
    area = len(nodes) * EDGE**2 / (2 * np.sqrt(3))  # of each hinge: a third of each triangle
    return float(energy / area / STIFFNESS / CURVATURE**2)


def dihedral_of_a_sphere() -> np.ndarray:
    """Angle of every hinge on a sphere, over k0 a."""
    mesh = hexagon(RINGS, EDGE)
    angles = hinge_angles(sphere(*mesh.points.T)[Topology.of(mesh.triangles).hinges])
    return angles / CURVATURE / EDGE


def bending_poisson_ratio() -> float:
    """That of the plate whose sphere costs as much more than its cylinder: 2 (1 + nu)."""
    return lattice_energy(sphere) / lattice_energy(cylinder) / 2 - 1


def stretching_poisson_ratio() -> float:
    """That of the membrane whose equal strain costs as much more than its uniaxial one."""
    mesh = hexagon(RINGS, EDGE)
    edges = Topology.of(mesh.triangles).edges
    flat = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    springs = EdgeSprings(edges, np.full(len(edges), STIFFNESS), np.full(len(edges), EDGE))
    along, equal = (
        springs.at((flat * [1 + 1e-5, 1 + across, 1]).reshape(-1)).energy().sum()
        for across in (0.0, 1e-5)
    )
    return float(equal / along / 2 - 1)
