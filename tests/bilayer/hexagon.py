"""A coarse disc that no mesh generator has a hand in, for what is compared with stored files."""

import numpy as np

from bilayer import PlanarMesh, paper_specimen

RADIUS = 0.04


def hexagon_mesh():
    """Return a hexagon of 24 equilateral triangles, two of them bare, its corners at R."""
    corners = [(0, 0)]
    for ring in (1, 2):
        for side in range(6):
            here, following = (np.exp(1j * np.pi / 3 * k) for k in (side, side + 1))
            steps = [here + (following - here) * k / ring for k in range(ring)]
            corners += [(ring * p.real, ring * p.imag) for p in steps]
    triangles = [(0, 1 + k, 1 + (k + 1) % 6) for k in range(6)]
    for k in range(6):
        inner, following = 1 + k, 1 + (k + 1) % 6
        corner, middle, last = 7 + 2 * k, 8 + 2 * k, 7 + (2 * k + 2) % 12
        triangles += [(inner, corner, middle), (inner, middle, following)]
        triangles += [(following, middle, last)]
    region = np.ones(len(triangles), dtype=int)
    region[[10, 11]] = 0
    return PlanarMesh(RADIUS / 2 * np.array(corners), np.array(triangles), region)


def hexagon_specimen(milestones=(1.06,)):
    """Return the paper's specimen without a cut pattern: the mesh says where it is bare."""
    return paper_specimen().with_layer("kirigami", pattern=None).with_milestones(milestones)
