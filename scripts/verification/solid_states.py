"""Homogeneous states of the finite-element model. SI units."""

from dataclasses import dataclass, replace

import dolfinx
import numpy as np
import ufl
from dolfinx import fem
from numpy.typing import NDArray

from bilayer import MooneyRivlin
from bilayer.errors import ComputationError
from verification.solid_problem import (
    held_where,
    mean,
    newton_of,
    rectangle,
    solid_of,
    stacked,
    stress,
)

TAPE = MooneyRivlin(4839.1, 14536.0)
COMPRESSIBLE_TAPE = MooneyRivlin(4839.1, 14536.0, 1.03918061e-6)
PATCH_GRADIENT = np.array([[1.10, 0.05, 0.02], [-0.03, 0.95, 0.04], [0.01, -0.02, 1.02]])
SIDE, THICKNESS = 2e-3, 1e-3


def block(material):
    """A block of one material."""
    return solid_of(stacked(rectangle(SIDE, SIDE, 2, 2), [THICKNESS]), [material])


def solve_block(solid, natural, sides):
    """The state of a prestretched block held at x, y = 0, on its top, and at SIDE for the `sides`.

    A side is the axis, x or y, along which the block is held at SIDE, too.
    """
    x, y, thickness = natural
    solid.layers[0].natural.value = (x, 0.0, y, thickness)
    held = [held_where(solid, 2, lambda x: np.isclose(x[2], 0))]
    for axis in range(2):
        places = (0.0, SIDE) if axis in sides else (0.0,)
        held += [
            held_where(solid, axis, lambda x, a=axis, p=p: np.isclose(x[a], p)) for p in places
        ]
    with newton_of(solid, held, iteration_limit=30) as newton:
        outcome = newton.solve(solid.undeformed, 1e-12)
    if not outcome.converged:
        raise ComputationError(f"no homogeneous state: {outcome.reason}")
    return outcome.state


def uniaxial_stress(solid, stretch: float) -> float:
    """Nominal stress of a block stretched along x, Pa."""
    state = solve_block(solid, (stretch, 1.0, 1.0), sides={0})
    return mean(solid, state, stress(solid)[0, 0])  # natural area = area of the mesh here


def equibiaxial_stress(solid, stretch: float) -> tuple[float, float]:
    """Cauchy stresses, xx and yy, of a block stretched along x and y, Pa."""
    state = solve_block(solid, (stretch, stretch, 1.0), sides={0, 1})
    gradient = solid.gradient
    cauchy = stress(solid) * gradient.T / ufl.det(gradient)
    return mean(solid, state, cauchy[0, 0]), mean(solid, state, cauchy[1, 1])


def planar_stress(solid, stretch: float) -> tuple[float, float]:
    """Nominal stresses, along and across, of a block stretched along x whose width is held, Pa."""
    state = solve_block(solid, (stretch, 1.0, 1.0), sides={0, 1})
    P = stress(solid)  # per area of the mesh, whose width is the natural one
    return mean(solid, state, P[0, 0]), stretch * mean(solid, state, P[1, 1])


@dataclass(frozen=True)
class Patch:
    """A distorted mesh under a uniform deformation of its boundary."""

    volume_ratio: float
    energy_density: float
    stress: NDArray[np.float64]
    unevenness: float


def compressible_patch(law=COMPRESSIBLE_TAPE) -> Patch:
    """The patch test of rung 2: mean values, and the rms distance of grad(x) from uniform."""
    side = 3e-3
    volume = stacked(rectangle(side, side, 3, 3), [side], elements=3)
    inside = np.all(
        (volume.points > [1e-4, 1e-4, -2.9e-3]) & (volume.points < [2.9e-3, 2.9e-3, -1e-4]), axis=1
    )
    shift = np.random.default_rng(1).uniform(-2e-4, 2e-4, volume.points.shape)
    volume = replace(volume, points=volume.points + shift * inside[:, None])
    F = PATCH_GRADIENT
    solid = solid_of(volume, [law])
    domain = solid.mesh.mesh
    domain.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(domain.topology)
    space, _ = solid.space.sub(0).collapse()
    prescribed = fem.Function(space)
    prescribed.interpolate(lambda x: (F - np.eye(3)) @ x)
    dofs = fem.locate_dofs_topological((solid.space.sub(0), space), 2, facets)
    guess = solid.interpolate(lambda x: (F - np.eye(3)) @ x + 1e-4 * np.sin(2e3 * x[::-1]))
    with newton_of(solid, [fem.dirichletbc(prescribed, dofs, solid.space.sub(0))]) as newton:
        outcome = newton.solve(guess, 1e-13)
    if not outcome.converged:
        raise ComputationError(f"no solution of the patch: {outcome.reason}")
    P, state = stress(solid), outcome.state
    off = solid.gradient - ufl.as_matrix(F)
    return Patch(
        mean(solid, state, ufl.det(solid.gradient)),
        solid.layer_energy(0, state) / side**3,
        np.array([[mean(solid, state, P[i, j]) for j in range(3)] for i in range(3)]),
        mean(solid, state, ufl.inner(off, off)) ** 0.5,
    )
