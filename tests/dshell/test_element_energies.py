"""Both energies: derivatives against finite differences, and rigid motions (ladder, rung 14)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges, hinge_angles

COUNT = 200


def apart(nodes):
    """Elements that share no nodes."""
    return np.arange(COUNT * nodes).reshape(COUNT, nodes)


def springs(rng):
    return EdgeSprings(apart(2), rng.uniform(0.5, 2, COUNT), rng.uniform(0.5, 2, COUNT))


def hinges(rng):
    return Hinges(apart(4), rng.uniform(0.5, 2, COUNT), rng.uniform(-2, 2, COUNT))


def folded_hinge(angle):
    """A hinge about the y axis whose triangles both slope down by half of `angle`."""
    c, s = np.cos(angle / 2), np.sin(angle / 2)
    return np.array([[0, 0, 0], [0, 1, 0], [-c, 0.2, -s], [c, 0.7, -s]], dtype=float)


def random_hinges(rng):
    """Hinges of any angle short of a full fold, where the angle jumps by a turn."""
    angles = rng.uniform(-3, 3, COUNT)
    rough = np.array([folded_hinge(angle) for angle in angles])
    return rough + rng.uniform(-0.05, 0.05, rough.shape)


def random_springs(rng):
    return rng.normal(size=(COUNT, 2, 3))


@pytest.fixture(params=[(springs, random_springs), (hinges, random_hinges)], ids=["edge", "hinge"])
def energy_and_corners(request):
    rng = np.random.default_rng(1)
    make_energy, make_corners = request.param
    return make_energy(rng), make_corners(rng)


def forces(energy, corners):
    return energy.at(corners.reshape(-1)).gradient().reshape(corners.shape)


def central_differences(function, corners, step=1e-5):
    """Fourth-order differences by every coordinate, in a last axis."""
    columns = []
    for index in np.ndindex(corners.shape[1:]):
        shift = np.zeros(corners.shape[1:])
        shift[index] = step
        near = function(corners + shift) - function(corners - shift)
        far = function(corners + 2 * shift) - function(corners - 2 * shift)
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def test_gradient_is_the_derivative_of_the_energy(energy_and_corners):
    energy, corners = energy_and_corners
    gradient = forces(energy, corners).reshape(COUNT, -1)
    expected = central_differences(lambda x: energy.at(x.reshape(-1)).energy(), corners)
    assert np.abs(gradient - expected).max() < 1e-7 * np.abs(gradient).max()


def test_hessian_is_the_derivative_of_the_gradient(energy_and_corners):
    energy, corners = energy_and_corners
    (stencil,), (hessian,) = energy.stencils, energy.at(corners.reshape(-1)).hessian()
    slopes = central_differences(lambda x: forces(energy, x).reshape(COUNT, -1), corners)
    order = stencil - stencil.min(axis=1, keepdims=True)
    expected = np.stack([part[np.ix_(at, at)] for part, at in zip(slopes, order, strict=True)])
    assert np.abs(hessian - expected).max() < 1e-7 * np.abs(hessian).max()
    assert np.array_equal(hessian, hessian.transpose(0, 2, 1))


def test_a_rigid_motion_changes_nothing(energy_and_corners):
    energy, corners = energy_and_corners
    rotation = Rotation.from_rotvec([0.7, -1.9, 0.4])
    shift = np.array([3.0, -2.0, 1.0])
    moved = rotation.apply(corners.reshape(-1, 3)).reshape(corners.shape) + shift
    turned = rotation.apply(forces(energy, corners).reshape(-1, 3)).reshape(corners.shape)
    before, after = (energy.at(x.reshape(-1)).energy() for x in (corners, moved))
    assert np.allclose(after, before, rtol=1e-9, atol=1e-12)
    assert np.abs(forces(energy, moved) - turned).max() < 1e-9 * np.abs(turned).max()


def test_forces_of_an_element_balance(energy_and_corners):
    energy, corners = energy_and_corners
    pulls = forces(energy, corners)
    moments = np.cross(corners, pulls)
    assert np.abs(pulls.sum(axis=1)).max() < 1e-9 * np.abs(pulls).max()
    assert np.abs(moments.sum(axis=1)).max() < 1e-9 * np.abs(moments).max()


@pytest.mark.parametrize("angle", [-3.0, -1.0, 0.0, 0.3, 2.5])
def test_angle_is_that_between_the_normals_and_positive_for_a_ridge(angle):
    assert hinge_angles(folded_hinge(angle)[None]) == pytest.approx([angle], abs=1e-12)


def test_spring_energy_is_the_printed_one():
    spring = EdgeSprings(np.array([[0, 1]]), np.array([3.0]), np.array([2.0]))
    stretched = spring.at(np.array([0, 0, 0, 0, 0, 2.5]))
    assert stretched.energy() == pytest.approx([1.5 * 0.25**2])


def test_hinge_energy_is_the_printed_one():
    hinge = Hinges(np.array([[0, 1, 2, 3]]), np.array([3.0]), np.array([0.2]))
    assert hinge.at(folded_hinge(0.7).reshape(-1)).energy() == pytest.approx([1.5 * 0.5**2])
