"""Homogeneous states with a closed form: rungs 1 and 2 of the verification ladder, prestresses."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

import dolfinx
import ufl
from dolfinx import fem
from verification.solid_problem import (
    held_where,
    mean,
    newton_of,
    rectangle,
    solid_of,
    stacked,
    stress,
)

from bilayer import LinearElastic, MooneyRivlin

TAPE = MooneyRivlin(4839.1, 14536.0)
SIDE, THICKNESS = 2e-3, 1e-3


@pytest.fixture(scope="module")
def tape_block():
    """One solid for every state of the incompressible tape, so that it is compiled once."""
    return solid_of(stacked(rectangle(SIDE, SIDE, 2, 2), [THICKNESS]), [TAPE])


def solve_block(solid, natural, sides):
    """Hold a prestretched block at x, y = 0, on its top, and at x or y = SIDE for the `sides`."""
    solid.layers[0].natural.value = natural
    solid.state.x.array[:] = 0.0
    held = [held_where(solid, 2, lambda x: np.isclose(x[2], 0))]
    for axis in range(2):
        places = (0.0, SIDE) if axis in sides else (0.0,)
        held += [
            held_where(solid, axis, lambda x, a=axis, p=p: np.isclose(x[a], p)) for p in places
        ]
    newton = newton_of(solid, held, iteration_limit=30)
    outcome = newton.solve(1e-12)
    newton.destroy()
    assert outcome.converged


@pytest.mark.parametrize(("stretch", "published"), [(1.06, 6307.92), (1.24, 19530.72)])
def test_uniaxial_nominal_stress(tape_block, stretch, published):
    solve_block(tape_block, (stretch, 1.0, 1.0), sides={0})
    nominal = mean(tape_block, stress(tape_block)[0, 0])  # natural area = area of the mesh here
    exact = 2 * (stretch - stretch**-2) * (TAPE.c10 + TAPE.c01 / stretch)
    assert nominal == pytest.approx(exact, rel=1e-6)
    assert nominal == pytest.approx(published, abs=0.01)


@pytest.mark.parametrize(("stretch", "published"), [(1.06, 14037.14), (1.24, 60612.61)])
def test_equibiaxial_cauchy_stress(tape_block, stretch, published):
    solve_block(tape_block, (stretch, stretch, 1.0), sides={0, 1})
    gradient = tape_block.gradient
    cauchy = stress(tape_block) * gradient.T / ufl.det(gradient)
    exact = 2 * (stretch**2 - stretch**-4) * (TAPE.c10 + TAPE.c01 * stretch**2)
    assert mean(tape_block, cauchy[0, 0]) == pytest.approx(exact, rel=1e-6)
    assert mean(tape_block, cauchy[1, 1]) == pytest.approx(published, abs=0.01)
    assert mean(tape_block, gradient[2, 2]) == pytest.approx(stretch**-2, rel=1e-9)


def test_a_hanging_block_carries_its_weight():
    """Balance: the mean of P33 over a block hung at z = 0 is half the stress there, q h / 2."""
    weight = 3e4
    volume = stacked(rectangle(SIDE, SIDE, 2, 2), [THICKNESS])
    solid = solid_of(volume, [TAPE], body_force=-weight)
    top = [held_where(solid, axis, lambda x: np.isclose(x[2], 0)) for axis in range(3)]
    newton = newton_of(solid, top)
    assert newton.solve(1e-13).converged
    newton.destroy()
    assert mean(solid, stress(solid)[2, 2]) == pytest.approx(weight * THICKNESS / 2, rel=1e-8)


def test_compressible_patch():
    """A uniform deformation of the boundary of a distorted mesh is uniform inside."""
    volume = stacked(rectangle(3e-3, 3e-3, 3, 3), [3e-3], elements=3)
    inside = np.all(
        (volume.points > [1e-4, 1e-4, -2.9e-3]) & (volume.points < [2.9e-3, 2.9e-3, -1e-4]), axis=1
    )
    shift = np.random.default_rng(1).uniform(-2e-4, 2e-4, volume.points.shape)
    volume = replace(volume, points=volume.points + shift * inside[:, None])
    assert inside.sum() == 8
    F = np.array([[1.10, 0.05, 0.02], [-0.03, 0.95, 0.04], [0.01, -0.02, 1.02]])
    solid = solid_of(volume, [MooneyRivlin(4839.1, 14536.0, 1.03918061e-6)])
    domain = solid.mesh.mesh
    domain.topology.create_connectivity(2, 3)
    facets = dolfinx.mesh.exterior_facet_indices(domain.topology)
    space, _ = solid.space.sub(0).collapse()
    prescribed = fem.Function(space)
    prescribed.interpolate(lambda x: (F - np.eye(3)) @ x)
    dofs = fem.locate_dofs_topological((solid.space.sub(0), space), 2, facets)
    newton = newton_of(solid, [fem.dirichletbc(prescribed, dofs, solid.space.sub(0))])
    solid.state.sub(0).interpolate(lambda x: (F - np.eye(3)) @ x + 1e-4 * np.sin(2e3 * x[::-1]))
    assert newton.solve(1e-13).converged
    assert mean(solid, ufl.det(solid.gradient)) == pytest.approx(np.linalg.det(F), rel=1e-8)
    energy = solid.layer_energy(0) / 27e-9
    assert energy == pytest.approx(4912.431674, rel=1e-8)
    uneven = mean(
        solid, ufl.inner(solid.gradient - ufl.as_matrix(F), solid.gradient - ufl.as_matrix(F))
    )
    assert uneven < 1e-16
    P = stress(solid)
    expected = {(0, 0): 132341.4487, (0, 1): 4765.5975, (2, 2): 137236.8145}
    for (i, j), value in expected.items():
        assert mean(solid, P[i, j]) == pytest.approx(value, rel=1e-8)


@pytest.mark.parametrize("poisson_ratio", [0.3, 0.5])
def test_prestress_of_the_linear_law(poisson_ratio):
    """Eq. 8 corrected: the bonded flat state has the stress E eps / (1 - nu), and none across."""
    material, strain = LinearElastic(116250.0, poisson_ratio), 0.08
    solid = solid_of(stacked(rectangle(SIDE, SIDE, 2, 2), [THICKNESS]), [material])
    solve_block(solid, (1 + strain, 1 + strain, 1.0), sides={0, 1})
    thinning = (1 + strain) ** -2
    assert mean(solid, solid.gradient[2, 2]) == pytest.approx(thinning, rel=1e-9)
    per_bonded_area = mean(solid, stress(solid)[0, 0]) / thinning
    assert per_bonded_area == pytest.approx(116250.0 * strain / (1 - poisson_ratio), rel=1e-9)
    assert abs(mean(solid, stress(solid)[2, 2])) < 1e-6
