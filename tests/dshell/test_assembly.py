import numpy as np
import pytest

from dshell.energies.assembly import Assembly, coordinates_of, deform, gradient_of, total_energies
from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges
from dshell.energies.topology import Topology

HELD = [0, 5]


@pytest.fixture(scope="module")
def shell(coarse_mesh):
    """Energies of order one on the coarse mesh, in a rough shape."""
    rng = np.random.default_rng(2)
    flat = np.column_stack([coarse_mesh.points, np.zeros(len(coarse_mesh.points))]) / 0.01
    topology = Topology.of(coarse_mesh.triangles)
    count = len(topology.hinges)
    lengths = np.linalg.norm(np.diff(flat[topology.edges], axis=1)[:, 0], axis=1)
    energies = (
        EdgeSprings(topology.edges, np.ones(len(lengths)), 0.9 * lengths),
        Hinges(topology.hinges, np.ones(count), rng.uniform(-0.5, 0.5, count)),
    )
    return energies, flat + rng.uniform(-0.2, 0.2, flat.shape)


def assembly_of(energies, positions):
    held = coordinates_of(np.array(HELD)).reshape(-1)
    return Assembly(positions.size, energies, held)


def free_dofs(positions):
    return np.delete(np.arange(positions.size).reshape(-1, 3), HELD, axis=0).reshape(-1)


def test_gradient_and_hessian_are_the_sums_over_elements(shell):
    energies, positions = shell
    size = positions.size
    gradient, hessian = np.zeros(size), np.zeros((size, size))
    for term in energies:
        bent = term.at(positions.reshape(-1))
        gradient += bent.gradient()
        for dofs, block in zip(term.stencils[0], bent.hessian()[0], strict=True):
            hessian[np.ix_(dofs, dofs)] += block
    assembly = assembly_of(energies, positions)
    free = free_dofs(positions)
    deformed = deform(energies, positions)
    assert gradient_of(deformed) == pytest.approx(gradient, abs=1e-12)
    assembled = assembly.hessian(deformed).toarray()
    assert np.abs(assembled - hessian[np.ix_(free, free)]).max() < 1e-12 * np.abs(hessian).max()


def test_whole_hessian_is_the_derivative_of_the_whole_gradient(shell):
    energies, positions = shell
    assembly = assembly_of(energies, positions)
    direction = np.random.default_rng(3).normal(size=positions.shape)
    direction[HELD] = 0
    step = 1e-6 * direction
    change = gradient_of(deform(energies, positions + step))
    change -= gradient_of(deform(energies, positions - step))
    free = free_dofs(positions)
    product = assembly.hessian(deform(energies, positions)) @ direction.reshape(-1)[free]
    assert product == pytest.approx(change[free] / 2e-6, abs=1e-7 * np.abs(product).max())


def test_pattern_is_fixed_and_holds_the_diagonal(shell):
    energies, positions = shell
    assembly = assembly_of(energies, positions)
    diagonal = np.arange(1.0, 1 + len(free_dofs(positions)))
    deformed = deform(energies, positions)
    plain = assembly.hessian(deformed)
    shifted = assembly.hessian(deform(energies, 1.3 * positions), diagonal)
    assert np.array_equal(plain.indices, shifted.indices)
    assert np.array_equal(plain.indptr, shifted.indptr)
    added = assembly.hessian(deformed, diagonal) - plain
    assert added.diagonal() == pytest.approx(diagonal)
    assert abs(added).sum() == pytest.approx(diagonal.sum())


def test_energy_by_name(shell):
    energies, positions = shell
    totals = total_energies(energies, positions)
    expected = {term.name: term.at(positions.reshape(-1)).energy().sum() for term in energies}
    assert totals == pytest.approx(expected)
    assert set(totals) == {"stretching", "bending"}
