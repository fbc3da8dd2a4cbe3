import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.solid_problem import rectangle, solid_of, stacked

from bilayer import MooneyRivlin


@pytest.fixture
def solid():
    """A solid whose displacement is its position, so that every dof tells where it is."""
    volume = stacked(rectangle(3e-3, 2e-3, 3, 2), [1e-3, 5e-4])
    solid = solid_of(volume, [MooneyRivlin(4839.1, 14536.0, 1e-6)] * 2)
    solid.state.sub(0).interpolate(lambda x: x)
    for layer in range(2):
        solid.state.sub(1 + layer).interpolate(lambda x: x[0] + 10 * x[1] + 100 * x[2])
    return solid


@pytest.mark.mpi
def test_values_are_gathered_in_the_original_order(solid):
    assert solid.vertex_displacements() == pytest.approx(solid.mesh.volume.points, abs=1e-15)


@pytest.mark.mpi
def test_dofs_are_found_by_original_vertex_numbers(solid):
    points = solid.mesh.volume.points
    comm = solid.mesh.mesh.comm
    for vertex in (0, 7, len(points) - 1):
        expected = [*points[vertex], points[vertex] @ [1, 10, 100]]
        spaces = [*(solid.component(axis) for axis in range(3)), solid.pressure_space(1)]
        for space, value in zip(spaces, expected, strict=True):
            dofs = solid.mesh.dofs_at(space, np.array([vertex]))
            assert solid.state.x.array[dofs] == pytest.approx(value, rel=1e-9, abs=1e-15)
            assert comm.allreduce(len(dofs)) >= 1


@pytest.mark.mpi
def test_pressures_are_held_outside_their_layer_alone(solid):
    """Three levels of 12 vertices: the lowest has no upper pressure, the highest no lower one."""
    heights = {}
    for layer, condition in enumerate(solid.absent_pressures()):
        dofs, _ = condition.dof_indices()
        solid.state.x.array[:] = 0.0
        solid.state.x.array[dofs] = 1.0
        marked = solid.mesh.gather(solid.pressure_space(layer), solid.state.x.array) == 1.0
        heights[layer] = set(solid.mesh.volume.points[marked, 2])
        assert marked.sum() == 12
    assert heights == {0: {5e-4}, 1: {-1e-3}}
    assert solid.number_of_pressures == 48
