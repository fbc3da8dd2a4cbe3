"""Plates under pressure, small deflections. SI units.

References: Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, table 8 (square), and
sections 16 and 17 (circular).
"""

import numpy as np

from dshell.energies.assembly import coordinates_of
from verification.meshes import disc, rectangle
from verification.shell_problem import Problem, clamp_layer, plate, pressure, single_layer

THICKNESS, YOUNG, LOAD = 0.03, 1e6, 0.006  # of a plate of side or radius 1
LINEAR = 1e-5  # tolerance: deflections are at most 0.004 of the thickness


def bending_stiffness(poisson_ratio: float) -> float:
    return YOUNG * THICKNESS**3 / 12 / (1 - poisson_ratio**2)


def supported_square(cells: int, poisson_ratio: float = 0.5) -> float:
    """Centre deflection of a simply supported square plate, times D / (q a^4)."""
    mesh = rectangle(*[np.linspace(0, 1.0, cells + 1)] * 2)
    faces, flat = plate(mesh, [single_layer(YOUNG, poisson_ratio, THICKNESS)])
    corner = coordinates_of(np.array([0, cells * (cells + 1)]))
    held = np.concatenate([3 * mesh.rim_nodes + 2, corner[0, :2], corner[1, 1:2]])
    state = Problem(faces, flat, held, pressure(mesh, len(flat), LOAD)).solved(LINEAR)
    middle = np.argmin(np.linalg.norm(mesh.points - 0.5, axis=1))
    return float(state[3 * middle + 2] * bending_stiffness(poisson_ratio) / LOAD)


def supported_disc(rings: int, poisson_ratio: float) -> float:
    """Centre deflection of a simply supported circular plate, times 64 D / (q a^4)."""
    mesh = disc(rings, 1 / rings)
    faces, flat = plate(mesh, [single_layer(YOUNG, poisson_ratio, THICKNESS)])
    far = coordinates_of(np.array([mesh.centre_node, np.argmax(mesh.points[:, 0])]))
    held = np.concatenate([3 * mesh.rim_nodes + 2, far[0, :2], far[1, 1:2]])
    state = Problem(faces, flat, held, pressure(mesh, len(flat), LOAD)).solved(LINEAR)
    return float(64 * state[3 * mesh.centre_node + 2] * bending_stiffness(poisson_ratio) / LOAD)


def clamped_disc(rings: int, poisson_ratio: float) -> float:
    """Centre deflection of a clamped circular plate, times 64 D / (q a^4)."""
    mesh = disc(rings + 1, 1 / rings)  # the last ring is the clamp
    fixed = np.flatnonzero(np.linalg.norm(mesh.points, axis=1) > 1 - 0.5 / rings)
    layers = [
        single_layer(YOUNG, poisson_ratio, THICKNESS),
        clamp_layer(mesh, fixed, YOUNG, THICKNESS),
    ]
    faces, flat = plate(mesh, layers)
    held = coordinates_of(fixed).reshape(-1)
    state = Problem(faces, flat, held, pressure(mesh, len(flat), LOAD)).solved(LINEAR)
    return float(64 * state[3 * mesh.centre_node + 2] * bending_stiffness(poisson_ratio) / LOAD)
