import numpy as np
import pytest

from bilayer import PlanarMesh
from fenics_model.mesh.volume_mesh import Slab, extrude


@pytest.fixture
def planar():
    """A unit square of four triangles around a node off its middle; two of them are bare."""
    points = [[0, 0], [1, 0], [1, 1], [0, 1], [0.4, 0.6]]
    triangles = [[4, 0, 1], [1, 2, 4], [4, 2, 3], [3, 0, 4]]  # no common order
    return PlanarMesh(points, triangles, [1, 1, 0, 0])


def volumes(mesh):
    edges = mesh.points[mesh.cells[:, 1:]] - mesh.points[mesh.cells[:, :1]]
    return np.abs(np.linalg.det(edges)) / 6


@pytest.mark.parametrize("elements", [1, 3])
def test_layers_fill_their_slabs(planar, elements):
    covered = planar.triangles[planar.region == 1]
    mesh = extrude(planar, [Slab(0.5, elements, planar.triangles), Slab(0.25, 2, covered)])
    assert volumes(mesh)[mesh.layer == 0].sum() == pytest.approx(0.5)
    assert volumes(mesh)[mesh.layer == 1].sum() == pytest.approx(0.25 * planar.areas[:2].sum())
    assert volumes(mesh).min() > 0
    assert len(mesh.cells) == 3 * (4 * elements + 2 * 2)


def test_tetrahedra_meet_face_to_face(planar):
    mesh = extrude(planar, [Slab(0.5, 2, planar.triangles), Slab(0.25, 1, planar.triangles)])
    faces = np.sort(mesh.cells[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]], axis=2)
    faces, count = np.unique(faces.reshape(-1, 3), axis=0, return_counts=True)
    assert count.max() == 2
    outer = mesh.points[faces[count == 1]]
    on_the_hull = np.zeros(len(outer), dtype=bool)
    for axis, ends in enumerate([(0, 1), (0, 1), (-0.5, 0.25)]):
        for end in ends:
            on_the_hull |= np.all(np.isclose(outer[:, :, axis], end), axis=1)
    assert on_the_hull.all()


def test_the_interface_lies_over_the_planar_nodes(planar):
    covered = planar.triangles[planar.region == 1]
    mesh = extrude(planar, [Slab(0.5, 2, planar.triangles), Slab(0.25, 1, covered)])
    interface = mesh.points[mesh.reference_surface]
    assert interface[:, :2] == pytest.approx(planar.points)
    assert np.all(interface[:, 2] == 0)
    assert mesh.vertex_at[3].tolist().count(-1) == 1  # node 3 has no kirigami


@pytest.mark.parametrize("below", [0, 1, 2])
def test_the_interface_lies_over_the_slabs_below_it(planar, below):
    """With the kirigami below, or with no layer there at all."""
    covered = planar.triangles[planar.region == 1]
    slabs = [Slab(0.25, 1, covered), Slab(0.5, 2, planar.triangles), Slab(0.125, 1, covered)]
    mesh = extrude(planar, slabs[1 - min(below, 1) :], below)
    depth = {0: 0.0, 1: 0.25, 2: 0.75}[below]
    levels = np.unique(mesh.points[:, 2])
    expected = np.array([0, 0.25, 0.5, 0.75, 0.875]) - depth
    assert levels == pytest.approx(expected if below else [0, 0.25, 0.5, 0.625])
    on_bond = mesh.points[mesh.reference_surface[mesh.reference_surface >= 0]]
    assert np.all(on_bond[:, 2] == 0)
