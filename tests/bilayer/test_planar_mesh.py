"""The planar mesh: topology, checks, files."""

import numpy as np
import pytest

from bilayer import InputError, PlanarMesh, read_planar_mesh, write_planar_mesh

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def two_triangles():
    return PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 0])


def test_edges_rim_and_areas_of_a_square():
    mesh = two_triangles()
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert mesh.boundary_edges.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]
    assert mesh.rim_nodes.tolist() == [0, 1, 2, 3]
    assert mesh.areas.tolist() == [0.5, 0.5]
    assert mesh.kirigami_nodes.tolist() == [True, True, True, False]
    assert mesh.centre_node == 0


@pytest.mark.parametrize(
    ("points", "triangles", "region", "message"),
    [
        (SQUARE, [[0, 2, 1], [0, 2, 3]], [1, 1], "triangle 0 has area -0.5"),
        (SQUARE, [[0, 1, 2]], [1], "use 3 of 4 points"),
        (SQUARE, [[0, 1, 2], [0, 2, 4]], [1, 1], "outside 0..3"),
        (SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 2], "region has values"),
        (SQUARE, [[0, 1, 2], [0, 2, 3]], [1], "region has shape"),
        (SQUARE * np.nan, [[0, 1, 2], [0, 2, 3]], [1, 1], "not all finite"),
    ],
)
def test_bad_meshes_are_refused(points, triangles, region, message):
    with pytest.raises(InputError, match=message):
        PlanarMesh(points, triangles, region)


@pytest.mark.parametrize("ending", ["msh", "vtu", "vtk"])
def test_files_keep_order_and_region(tmp_path, ending):
    mesh = two_triangles()
    path = tmp_path / f"mesh.{ending}"
    write_planar_mesh(mesh, path)
    assert read_planar_mesh(path).same_as(mesh)


def test_nodes_without_triangles_are_dropped(tmp_path):
    """gmsh files often hold construction points."""
    import meshio

    path = tmp_path / "mesh.vtk"
    points = np.column_stack([np.vstack([[[9.0, 9.0]], SQUARE]), np.zeros(5)])
    meshio.Mesh(points, [("triangle", np.array([[1, 2, 3], [1, 3, 4]]))]).write(path)
    mesh = read_planar_mesh(path)
    assert len(mesh.points) == 4
    assert mesh.region.tolist() == [1, 1]


def test_files_that_hold_no_planar_mesh_are_named(tmp_path):
    (tmp_path / "a.vtk").write_text("nonsense")
    for name in ("a.vtk", "missing.vtk", "mesh.unknown"):
        with pytest.raises(InputError, match=f"mesh file .*{name}"):
            read_planar_mesh(tmp_path / name)
    with pytest.raises(InputError, match="cannot be written"):
        write_planar_mesh(two_triangles(), tmp_path / "mesh.unknown")
