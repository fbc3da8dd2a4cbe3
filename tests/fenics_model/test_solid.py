"""The solid's derivatives, its invariances and its stability count (rung 14)."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from mpi4py import MPI
from verification.solid_problem import held_where, newton_of, rectangle, solid_of, stacked

from bilayer import LinearElastic, MooneyRivlin, NeoHookean
from fenics_model.stability import unstable_modes

TAPES = {
    "mooney-rivlin": (MooneyRivlin(4839.1, 14536.0, 1e-6), MooneyRivlin(30749.0, 30749.0, 3e-7)),
    "incompressible": (MooneyRivlin(4839.1, 14536.0), MooneyRivlin(30749.0, 30749.0)),
    "neo-hookean": (NeoHookean(19375.0, d1=1e-6), NeoHookean(61498.0, d1=1e-6)),
    "linear": (LinearElastic(116250.0, 0.5), LinearElastic(368988.0, 0.4)),
}


@pytest.fixture(params=TAPES)
def strained(request):
    """Two layers in a smooth, uneven state of finite strain, the lower one prestretched."""
    volume = stacked(rectangle(3e-3, 2e-3, 3, 2), [1e-3, 1e-3])
    solid = solid_of(volume, TAPES[request.param])
    solid.layers[0].natural.value = (1.1, 1.05, 1.0)
    solid.state.sub(0).interpolate(uneven)
    for layer in range(2):
        solid.state.sub(1 + layer).interpolate(lambda x: 1e-4 * np.cos(500 * x[0] + x[2] * 300))
    return solid


def uneven(x):
    return 1e-4 * np.array(
        [np.sin(600 * x[1]) + 500 * x[0], np.cos(700 * x[0] + 400 * x[2]), np.sin(800 * x[2])]
    )


def random_direction(solid, seed):
    """A direction that does not depend on the partition, from the values of smooth functions."""
    direction = solid.state.copy()
    frequency, phase = np.random.default_rng(seed).uniform(200, 900, (2, 3, 1))
    direction.sub(0).interpolate(lambda x: 1e-3 * np.sin(frequency * x + phase))
    for layer in range(2):
        direction.sub(1 + layer).interpolate(lambda x: 1e-3 * np.sin((frequency * x).sum(axis=0)))
    return direction.x.array.copy()


@pytest.mark.mpi
def test_residual_and_tangent_are_derivatives_of_the_energy(strained):
    """Against central differences extrapolated to fourth order."""
    newton = newton_of(strained, [])
    newton._held = []  # every dof is free here, also the pressures outside their layer
    values = strained.state.x.array
    here, along = values.copy(), random_direction(strained, seed=3)
    vector, image = newton._x, newton._x.duplicate()
    owned = slice(0, vector.local_size)

    def energy(step):
        values[:] = here + step * along
        return sum(strained.layer_energy(layer) for layer in range(2))

    def residual(step):
        values[:] = here + step * along
        newton.residual_norm()
        return newton._r.array.copy()

    def slope(function, h=2e-3):
        return (8 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12 * h)

    comm = strained.mesh.mesh.comm
    expected = comm.allreduce(residual(0.0) @ along[owned])
    assert slope(energy) == pytest.approx(expected, rel=1e-7)
    vector.array[:] = here[owned]
    newton._tangent(newton.snes, vector, newton.matrix, newton.matrix)
    vector.array[:] = along[owned]
    newton.matrix.mult(vector, image)
    difference = comm.allreduce(np.sum((slope(residual) - image.array) ** 2)) ** 0.5
    assert difference < 1e-7 * image.norm()
    newton.destroy()


@pytest.mark.mpi
def test_a_rigid_motion_changes_neither_energy_nor_residual(strained):
    newton = newton_of(strained, [])

    def measures():
        return [strained.layer_energy(0), strained.layer_energy(1), newton.residual_norm()]

    before = measures()
    turn = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    shift = np.array([[0.3], [-0.2], [0.1]]) * 1e-3
    strained.state.sub(0).interpolate(lambda x: turn @ (x + uneven(x)) + shift - x)
    assert measures() == pytest.approx(before, rel=1e-9)
    newton.destroy()


@pytest.mark.mpi
@pytest.mark.parametrize("stretch", [1.05, 0.93])
def test_the_inertia_counts_the_unstable_modes(stretch):
    """A clamped thin plate: in tension stable, in compression unstable though in balance."""
    volume = stacked(rectangle(8e-3, 4e-3, 4, 2), [1e-3])
    solid = solid_of(volume, [MooneyRivlin(4839.1, 14536.0, 1e-6)])
    ends = [
        held_where(solid, axis, lambda x: np.isclose(x[0] * (8e-3 - x[0]), 0)) for axis in (0, 1, 2)
    ]
    newton = newton_of(solid, ends)
    solid.layers[0].natural.value = (stretch, 1.0, 1.0)
    assert newton.solve(1e-12).converged
    counted = unstable_modes(newton, solid.number_of_pressures)
    if MPI.COMM_WORLD.size == 1:
        indptr, columns, entries = newton.matrix.getValuesCSR()
        dense = np.zeros((len(indptr) - 1,) * 2)
        dense[np.repeat(np.arange(len(dense)), np.diff(indptr)), columns] = entries
        negative = int(np.sum(np.linalg.eigvalsh(dense) < 0))
        assert counted == negative - solid.number_of_pressures
    assert (counted == 0) == (stretch > 1)
    newton.destroy()
