import numpy as np
import pytest

from bilayer import InputError
from dshell.energies.topology import Topology, sum_at_nodes

SQUARE = np.array([[0, 1, 2], [0, 2, 3]])


def test_a_square_of_two_triangles_has_one_hinge():
    topology = Topology.of(SQUARE)
    assert topology.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert topology.hinges.tolist() == [[2, 0, 1, 3]]
    assert topology.edges[topology.hinge_edges].tolist() == [[0, 2]]
    assert topology.hinge_faces.tolist() == [[0, 1]]


def test_hinges_of_a_disc(coarse_mesh):
    topology = Topology.of(coarse_mesh.triangles)
    assert np.array_equal(topology.edges, coarse_mesh.edges)
    assert len(topology.hinges) == len(topology.edges) - len(coarse_mesh.boundary_edges)
    turned = np.sort(topology.hinges[:, :2], axis=1)
    assert np.array_equal(turned, topology.edges[topology.hinge_edges])
    first, second = np.moveaxis(coarse_mesh.triangles[topology.hinge_faces], 1, 0)
    assert np.array_equal(np.sort(first), np.sort(topology.hinges[:, [0, 1, 2]]))
    assert np.array_equal(np.sort(second), np.sort(topology.hinges[:, [0, 1, 3]]))


def test_triangles_that_turn_against_each_other_are_refused():
    with pytest.raises(InputError, match="counterclockwise both"):
        Topology.of(np.array([[0, 1, 2], [0, 3, 2]]))


def test_three_triangles_at_an_edge_are_refused():
    with pytest.raises(InputError, match="at most two"):
        Topology.of(np.array([[0, 1, 2], [0, 2, 3], [0, 2, 4]]))


def test_sum_at_nodes():
    assert sum_at_nodes(SQUARE, np.array([1.0, 10.0])).tolist() == [11, 1, 11, 10]
