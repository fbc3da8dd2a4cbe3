"""The contact barrier on two rough plates, one over the other."""

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from verification.derivatives import derivative_by_points

from bilayer.contact.barrier import Barrier
from bilayer.contact.package import contact_is_installed, require_contact
from bilayer.errors import ComputationError

RANGE = 2e-4
STIFFNESS = 3e4
COUNT = 5
STEP = 3e-8


def plate(height, offset):
    """Return points and triangles of a rough square of 10 mm, slightly turned."""
    rng = np.random.default_rng(1 if offset else 0)
    x, y = np.meshgrid(*2 * [np.linspace(-5e-3, 5e-3, COUNT)])
    points = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3)
    points[:, :2] += rng.uniform(-3e-4, 3e-4, (len(points), 2)) + offset
    points[:, 2] += height + rng.uniform(-2e-5, 2e-5, len(points))
    corner = np.arange(COUNT * COUNT).reshape(COUNT, COUNT)
    a, b, c, d = (part.reshape(-1) for part in (
        corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))  # fmt: skip
    return points, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def two_plates(gap):
    (lower, triangles), (upper, _) = plate(0.0, 0.0), plate(gap, 3e-4)
    return np.concatenate([lower, upper]), np.concatenate([triangles, triangles + len(lower)])


@pytest.fixture
def barrier():
    if not contact_is_installed():
        pytest.skip("needs ipctk")
    apart, triangles = two_plates(5e-3)
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    neighbours = np.unique(np.sort(sides, axis=1), axis=0)
    fibres = np.arange(len(apart))
    return Barrier(triangles, apart, fibres, neighbours, range=RANGE, stiffness=STIFFNESS)


def test_derivatives_agree_with_finite_differences(barrier):
    points, _ = two_plates(1e-4)
    found = barrier.at(points)
    gradient = found.gradient.reshape(-1)
    expected = derivative_by_points(lambda x: barrier.at(x).energy, points, STEP)
    assert found.pairs > 20
    assert np.abs(gradient - expected).max() < 1e-7 * np.abs(expected).max()
    expected = derivative_by_points(lambda x: barrier.at(x).gradient.reshape(-1), points, STEP)
    assert np.abs(found.hessian() - expected).max() < 1e-7 * np.abs(expected).max()


def test_a_rigid_motion_changes_nothing(barrier):
    points, _ = two_plates(1e-4)
    turn, shift = Rotation.from_rotvec([0.7, -1.9, 0.4]), np.array([3e-3, -2e-3, 1e-3])
    before, after = barrier.at(points), barrier.at(turn.apply(points) + shift)
    assert after.energy == pytest.approx(before.energy, rel=1e-9)
    scale = np.abs(before.gradient).max()
    assert np.abs(after.gradient - turn.apply(before.gradient)).max() < 1e-9 * scale


def test_the_forces_and_their_moments_balance(barrier):
    points, _ = two_plates(1e-4)
    forces = barrier.at(points).gradient
    scale = np.abs(forces).sum()
    assert np.abs(forces.sum(axis=0)).max() < 1e-12 * scale
    assert np.abs(np.cross(points, forces).sum(axis=0)).max() < 1e-12 * scale
    assert forces[: len(forces) // 2, 2].sum() > 0.5 * scale / 2  # the upper one presses down


def test_nothing_acts_beyond_the_range_and_all_the_more_within(barrier):
    energies = [barrier.at(two_plates(gap)[0]).energy for gap in (3e-4, 1.5e-4, 1.2e-4, 0.9e-4)]
    assert energies[0] == 0
    assert 0 < energies[1] < energies[2] < energies[3]


def test_the_convex_hessian_has_no_negative_eigenvalue(barrier):
    found = barrier.at(two_plates(1e-4)[0])
    values = np.linalg.eigvalsh(found.convex_hessian().toarray())
    assert values.min() > -1e-9 * values.max()
    assert np.linalg.eigvalsh(found.hessian().toarray()).min() < -1e-3 * values.max()


def test_pairs_that_are_kept_miss_nothing(barrier):
    """From just out of range to well within it, and the same from far away, where all is sought."""
    far, beyond, within = (two_plates(gap)[0] for gap in (5e-3, 2.6e-4, 1.6e-4))
    assert barrier.at(beyond).pairs == 0
    kept = barrier.at(within).energy
    assert barrier.at(far).pairs == 0
    assert kept > 0
    assert kept == pytest.approx(barrier.at(within).energy, rel=1e-12)


def test_crossing_and_the_way_to_it(barrier):
    apart, through = two_plates(3e-4)[0], two_plates(-3e-4)[0]
    assert not barrier.is_crossed(apart)
    halfway = apart.copy()
    halfway[len(apart) // 2 :, 2] -= 3e-4 + 5e-3 * apart[len(apart) // 2 :, 0]
    assert barrier.is_crossed(halfway)
    share = barrier.free_share(apart, through)
    assert 0 < share < 0.6
    assert not barrier.is_crossed(apart + share * (through - apart))
    assert barrier.free_share(apart, two_plates(2.9e-4)[0]) == 1


def test_a_way_of_any_length_is_looked_at_in_parts(barrier, monkeypatch):
    apart, through = two_plates(3e-4)[0], two_plates(-3e-4)[0]
    once = barrier.free_share(apart, through)
    far = apart + 1e4 * (through - apart)
    parts = []
    whole = barrier._ipctk.compute_collision_free_stepsize

    def counted(mesh, begin, stop):
        parts.append(np.abs(stop - begin).max())
        return whole(mesh, begin, stop)

    monkeypatch.setattr(barrier._ipctk, "compute_collision_free_stepsize", counted)
    assert barrier.free_share(apart, far) * 1e4 == pytest.approx(once, rel=0.3)
    assert 1 <= len(parts) < 5
    assert not barrier.is_crossed(apart + barrier.free_share(apart, far) * (far - apart))
    assert max(parts) < 0.01 * np.abs(far - apart).max()


def test_what_is_found_clear_is_clear_for_a_while_and_no_longer(barrier):
    far, near, touching = (two_plates(gap)[0] for gap in (1e-3, 4.5e-4, 1e-4))
    assert not barrier.stays_clear(far, touching)
    assert barrier.stays_clear(far, near)
    assert barrier.at(near + 1e-5).pairs == 0
    assert barrier.at(touching).pairs > 0
    assert not barrier.stays_clear(near, touching)
    assert barrier.free_share(near, two_plates(-3e-4)[0]) < 1


def test_the_range_is_less_if_the_flat_skin_is_finer():
    if not contact_is_installed():
        pytest.skip("needs ipctk")
    apart, triangles = two_plates(1e-4)
    none = np.zeros((0, 2), dtype=int)
    halves = np.repeat([0, 1], len(apart) // 2)
    found = Barrier(triangles, apart, halves, none, range=RANGE, stiffness=STIFFNESS)
    assert found.range < 0.5 * 1e-4
    assert found.at(apart).pairs == 0


def test_without_the_package_one_line_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "ipctk", None)
    with pytest.raises(ComputationError, match=r"ipctk: pip install 'bilayer-shells\[contact\]'"):
        require_contact()
