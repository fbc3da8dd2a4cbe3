"""Implicit Euler against closed forms: oscillator, free fall, coasting mass; energy decay."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import ComputationError
from dshell.energies.assembly import total_energies
from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges
from dshell.energies.topology import Topology
from dshell.solve.dynamics import ConvergenceError, Motion, MovingBody, Stepping, implicit_euler

MASS, STIFFNESS, LENGTH = 0.3, 2.0, 0.5  # kg, J, m
FREQUENCY = np.sqrt(STIFFNESS / LENGTH**2 / MASS)  # rad/s: along itself the spring is linear


def spring_body(stiffness=STIFFNESS, load=(0, 0, 0), damping_rate=0.0):
    """A mass on a spring along x whose other end is held."""
    spring = EdgeSprings(np.array([[0, 1]]), np.array([stiffness]), np.array([LENGTH]))
    force = np.array([[0, 0, 0], load], dtype=float)
    held = np.arange(3)
    return MovingBody(
        np.full((2, 3), MASS), held, lambda now: (spring,), lambda now: force, damping_rate
    )


def spring_start(stretch=0.0, velocity=0.0):
    position = np.array([[0, 0, 0], [LENGTH + stretch, 0, 0]])
    return Motion(0.0, position, np.array([[0, 0, 0], [velocity, 0, 0]], dtype=float))


def stepping(time_step, steps, tolerance=1e-12, max_iterations=20):
    return Stepping(time_step, steps, tolerance, max_iterations)


def test_oscillator_follows_the_closed_form_of_implicit_euler():
    h, stretch, velocity = 0.02, 0.1, 0.3
    motions = list(implicit_euler(spring_body(), spring_start(stretch, velocity), stepping(h, 50)))
    turning = (stretch - 1j * velocity / FREQUENCY) / (1 - 1j * FREQUENCY * h) ** np.arange(1, 51)
    moved = [motion.position[1, 0] - LENGTH for motion in motions]
    assert moved == pytest.approx(turning.real, abs=1e-9)
    assert motions[-1].time == pytest.approx(1.0)


def test_oscillator_converges_at_first_order():
    errors = []
    for steps in (200, 400, 800):
        path = implicit_euler(spring_body(), spring_start(0.1), stepping(0.5 / steps, steps, 1e-8))
        *_, last = path
        errors.append(abs(last.position[1, 0] - LENGTH - 0.1 * np.cos(0.5 * FREQUENCY)))
    rates = np.log2(np.divide(errors[:-1], errors[1:]))
    assert rates == pytest.approx(1.0, abs=0.02)


def test_free_fall():
    h, pull = 0.1, 0.7
    body = spring_body(stiffness=1e-12, load=(MASS * pull, 0, 0))
    motions = list(implicit_euler(body, spring_start(), stepping(h, 10, tolerance=1e-10)))
    n = np.arange(1, 11)
    fallen = [motion.position[1, 0] - LENGTH for motion in motions]
    assert fallen == pytest.approx(pull * h**2 * n * (n + 1) / 2, rel=1e-8)


def test_drag_slows_a_coasting_mass():
    h, rate = 0.1, 2.0
    body = spring_body(stiffness=1e-12, damping_rate=rate)
    motions = list(implicit_euler(body, spring_start(velocity=0.4), stepping(h, 10, 1e-10)))
    speeds = [motion.velocity[1, 0] for motion in motions]
    assert speeds == pytest.approx(0.4 / (1 + rate * h) ** np.arange(1, 11), rel=1e-8)
    assert [motion.iterations for motion in motions] == [1] * 10  # a linear problem


def test_held_nodes_stay_whatever_pulls_them():
    body = replace(spring_body(), load=lambda now: np.ones((2, 3)))
    *_, last = implicit_euler(body, spring_start(0.1), stepping(0.02, 5))
    assert np.array_equal(last.position[0], [0, 0, 0])
    assert np.abs(last.velocity[1]).min() > 0


def test_load_and_energies_are_those_at_the_end_of_the_step():
    body = replace(spring_body(1e-12), load=lambda now: np.array([[0, 0, 0], [now * MASS, 0, 0]]))
    *_, last = implicit_euler(body, spring_start(), stepping(0.5, 2))
    assert last.velocity[1, 0] == pytest.approx(0.5 * (0.5 + 1.0))


@pytest.fixture(scope="module")
def shaken_shell(coarse_mesh):
    """A shell at rest, thrown at random."""
    topology = Topology.of(coarse_mesh.triangles)
    flat = np.column_stack([coarse_mesh.points, np.zeros(len(coarse_mesh.points))])
    lengths = np.linalg.norm(np.diff(flat[topology.edges], axis=1)[:, 0], axis=1)
    energies = (
        EdgeSprings(topology.edges, 100 * lengths**2, lengths),
        Hinges(topology.hinges, *np.array([[1e-4], [0.0]]) * np.ones(len(topology.hinges))),
    )
    count = len(flat)
    body = MovingBody(
        np.full((count, 3), 1e-4),
        np.arange(3),
        lambda now: energies,
        lambda now: np.zeros((count, 3)),
    )
    velocity = np.random.default_rng(4).normal(scale=0.05, size=flat.shape)
    velocity[0] = 0
    return body, Motion(0.0, flat, velocity)


def total_energy(body, motion):
    elastic = total_energies(body.energies(motion.time), motion.position)
    return sum(elastic.values()) + 0.5 * (body.masses * motion.velocity**2).sum()


def test_energy_decreases_at_every_step(shaken_shell):
    body, start = shaken_shell
    motions = [start, *implicit_euler(body, start, stepping(2e-3, 40, tolerance=1e-9))]
    energies = np.array([total_energy(body, motion) for motion in motions])
    assert np.all(np.diff(energies) < 0)
    assert energies[-1] < 0.5 * energies[0]


def test_newton_converges_quadratically(shaken_shell):
    body, start = shaken_shell
    errors = []
    for allowed in (1, 2, 3):
        with pytest.raises(ConvergenceError) as stop:
            list(implicit_euler(body, start, stepping(2e-3, 1, 1e-30, allowed)))
        errors.append(stop.value.error)
    assert errors[1] < 1e-1 * errors[0]
    assert errors[2] < 1e-3 * errors[1]


def test_a_step_that_does_not_converge_says_where_and_how(shaken_shell):
    body, start = shaken_shell
    with pytest.raises(ComputationError, match=r"at 0\.002 s: error .* after 1 iterations") as stop:
        list(implicit_euler(body, start, stepping(2e-3, 5, 1e-12, max_iterations=1)))
    assert stop.value.iterations == 1
    assert stop.value.error > 1e-12


def test_a_singular_jacobian_is_a_failed_step():
    sideways = np.array([[0, 0, 0], [0, 1.0, 0]])  # where an unstretched spring has no stiffness
    massless = replace(spring_body(), masses=np.zeros((2, 3)), load=lambda now: sideways)
    with pytest.raises(ConvergenceError, match="error nan N after 1"):
        list(implicit_euler(massless, spring_start(), stepping(0.1, 1)))
