import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.solid_problem import rectangle, solid_of, stacked

from bilayer import MooneyRivlin
from fenics_model.solid.numbering import Numbering


@pytest.fixture(scope="module")
def solid():
    volume = stacked(rectangle(3e-3, 2e-3, 3, 2), [1e-3, 5e-4])
    return solid_of(volume, [MooneyRivlin(4839.1, 14536.0, 1e-6)] * 2)


def place(x):
    """A number for each place."""
    return x[0] + 10 * x[1] + 100 * x[2]


@pytest.fixture(scope="module")
def state(solid):
    """The displacement is the position, so every dof tells where it is."""
    return solid.interpolate(lambda x: x, place, place)


@pytest.mark.mpi
def test_values_are_gathered_in_the_original_order(solid, state):
    found = solid.vertex_displacements(state)
    assert found == pytest.approx(solid.mesh.volume.points, abs=1e-15)


@pytest.mark.mpi
def test_all_dofs_have_an_order_of_their_own(solid, state):
    """Vertices, middles of edges, pressures by layer; what is gathered can be spread again."""
    numbering, points = Numbering(solid), solid.mesh.volume.points
    cells = np.sort(solid.mesh.volume.cells, axis=1)
    pairs = [cells[:, [a, b]] for a in range(4) for b in range(a + 1, 4)]
    edges = np.unique(np.vstack(pairs), axis=0)
    places = np.vstack([points, points[edges].mean(axis=1)])
    gathered = numbering.gather(state.values)
    pressures = np.tile(place(points.T), 2)
    assert gathered == pytest.approx(np.concatenate([places.ravel(), pressures]), abs=1e-12)
    assert np.array_equal(numbering.spread(gathered), state.values)
    assert gathered[numbering.displacements_at([5])] == pytest.approx(points[[5]])


@pytest.mark.mpi
def test_dofs_are_found_by_original_vertex_numbers(solid, state):
    points = solid.mesh.volume.points
    comm = solid.mesh.mesh.comm
    for vertex in (0, 7, len(points) - 1):
        expected = [*points[vertex], place(points[vertex])]
        spaces = [*(solid.component(axis) for axis in range(3)), solid.pressure_space(1)]
        for space, value in zip(spaces, expected, strict=True):
            dofs = solid.mesh.dofs_at(space, np.array([vertex]))
            assert state.values[dofs] == pytest.approx(value, rel=1e-9, abs=1e-15)
            assert comm.allreduce(len(dofs)) >= 1


@pytest.mark.mpi
def test_pressures_are_held_outside_their_layer_alone(solid):
    """Three levels of 12 vertices: the lowest has no upper pressure, the highest no lower one."""
    heights = {}
    for layer, condition in enumerate(solid.absent_pressures()):
        dofs, _ = condition.dof_indices()
        values = np.zeros_like(solid.undeformed.values)
        values[dofs] = 1.0
        marked = solid.mesh.gather(solid.pressure_space(layer), values) == 1.0
        heights[layer] = set(solid.mesh.volume.points[marked, 2])
        assert marked.sum() == 12
    assert heights == {0: {5e-4}, 1: {-1e-3}}
    assert solid.number_of_pressures == 48
