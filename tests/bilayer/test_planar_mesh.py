"""The planar mesh: topology, checks, files."""

import meshio
import numpy as np
import pytest
from grids import frame, grid_mesh, rectangle

from bilayer import InputError, PlanarMesh, read_planar_mesh, write_planar_mesh
from bilayer.mesh.files import read_mesh_file

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def two_triangles():
    return PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 0])


def test_edges_rim_and_areas_of_a_square():
    mesh = two_triangles()
    assert mesh.edges.tolist() == [[0, 1], [0, 2], [0, 3], [1, 2], [2, 3]]
    assert mesh.boundary_edges.tolist() == [[0, 1], [0, 3], [1, 2], [2, 3]]
    assert mesh.rim_nodes.tolist() == [0, 1, 2, 3]
    assert mesh.areas.tolist() == [0.5, 0.5]
    assert mesh.faces_of("kirigami").tolist() == [0]
    assert mesh.faces_of("substrate").tolist() == [0, 1]
    assert mesh.centre_node == 0


LATTICE = np.array([[x, y] for y in range(3) for x in range(4)], dtype=float)
NAN = np.where(np.arange(4)[:, None] == 2, np.nan, SQUARE)
BAD = {
    "not finite": (NAN, [[0, 1, 2], [0, 2, 3]], "node 2 lies at .*nan nan.*: expected finite"),
    "far away": (SQUARE * 1e300, [[0, 1, 2], [0, 2, 3]], "node 1 lies at .*300.*up to 1e"),
    "isolated": (SQUARE, [[0, 1, 2]], "node 3 is isolated: expected every node in a triangle"),
    "no such node": (SQUARE, [[0, 1, 2], [0, 2, 4]], r"triangle 1 \(nodes 0, 2, 4\): .* 0 to 3"),
    "negative": (SQUARE, [[0, 1, 2], [0, 2, -1]], r"triangle 1 \(nodes 0, 2, -1\): .* 0 to 3"),
    "clockwise": (
        SQUARE, [[0, 1, 2], [0, 3, 2]], r"triangle 1 \(nodes 0, 3, 2\) runs clockwise: expected"
    ),
    "all clockwise": (SQUARE, [[0, 2, 1], [0, 3, 2]], r"clockwise \(as are 1 more\)"),
    "no area": (SQUARE, [[0, 1, 2], [0, 2, 3], [1, 1, 2]], r"triangle 2 .* is degenerate"),
    "sliver": (
        np.vstack([SQUARE, [0.5, -1e-7]]),
        [[0, 1, 2], [0, 2, 3], [1, 0, 4]],
        r"triangle 2 \(nodes 1, 0, 4\) is degenerate, its area is 5e-08 m2: expected a height",
    ),
    "twice": (
        SQUARE, [[0, 1, 2], [0, 2, 3], [2, 0, 1]], r"triangle 0 \(nodes 0, 1, 2\) is there again "
        "as triangle 2: expected each once",
    ),
    "non-manifold": (
        np.vstack([SQUARE, [0.1, 0.9]]),
        [[0, 1, 2], [0, 2, 3], [0, 2, 4]],
        r"the edge of nodes 0 and 2 belongs to 3 triangles \(0, 1, 2\): expected at most 2",
    ),
    "folded": (
        np.vstack([SQUARE, [0.9, 0.1]]),
        [[0, 1, 2], [0, 1, 4], [0, 2, 3]],
        "triangles 0, 1 lie on the same side of the edge of nodes 0 and 1",
    ),
    "in pieces": (
        LATTICE, [[0, 1, 4], [1, 5, 4], [2, 3, 6], [3, 7, 6], [4, 5, 8], [5, 9, 8],
                  [6, 7, 10], [7, 11, 10]],
        r"in 2 pieces, triangle 2 \(nodes 2, 3, 6\) shares no edge",
    ),
    "joined at a node": (
        LATTICE[:7], [[0, 1, 5], [2, 6, 5], [3, 6, 2], [0, 5, 4]], "in 2 pieces",
    ),
}  # fmt: skip


@pytest.mark.parametrize(("points", "triangles", "message"), BAD.values(), ids=BAD)
def test_bad_meshes_are_refused(points, triangles, message):
    with pytest.raises(InputError, match=message):
        PlanarMesh(points, triangles, np.ones(len(triangles)))


@pytest.mark.parametrize(
    ("region", "message"),
    [
        ([1, 2], "triangle 1 has region = 2: expected 0 or 1"),
        ([0.5, 1], "triangle 0 has region = 0.5: expected 0 or 1"),
        ([1, np.nan], "triangle 1 has region = nan: expected 0 or 1"),
        ([1], "region has shape"),
    ],
)
def test_bad_regions_are_refused(region, message):
    with pytest.raises(InputError, match=message):
        PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], region)


@pytest.mark.parametrize("ending", ["msh", "vtu", "vtk"])
def test_files_keep_order_and_region(tmp_path, ending):
    mesh = two_triangles()
    path = tmp_path / f"mesh.{ending}"
    write_planar_mesh(mesh, path)
    assert read_planar_mesh(path).same_as(mesh)


def write_file(path, points, cells, **data):
    points = np.column_stack([points, np.zeros(len(points))]) if points.shape[1] == 2 else points
    meshio.Mesh(points, cells, cell_data=data).write(path)


def test_construction_points_are_left_out(tmp_path):
    """A drawing's points and lines may lie beside the triangles; other nodes are an error."""
    path, points = tmp_path / "mesh.vtk", np.vstack([[[9.0, 9.0]], SQUARE])
    triangles = ("triangle", np.array([[1, 2, 3], [1, 3, 4]]))
    write_file(path, points, [("vertex", np.array([[0], [1]])), triangles])
    mesh = read_planar_mesh(path)
    assert len(mesh.points) == 4
    assert mesh.region.tolist() == [1, 1]
    write_file(path, points, [triangles])
    with pytest.raises(InputError, match=r"mesh\.vtk: node 0 is isolated"):
        read_planar_mesh(path)


def test_centres_of_circles_in_gmsh_files_are_left_out(tmp_path):
    path, points = tmp_path / "mesh.msh", np.vstack([[[9.0, 9.0]], SQUARE])
    cells = [("triangle", np.array([[1, 2, 3], [1, 3, 4]]))]
    meshio.Mesh(np.pad(points, ((0, 0), (0, 1))), cells).write(path, file_format="gmsh22")
    assert len(read_planar_mesh(path).points) == 4


HOLDS_LAYERS = ["msh", "vtu", "vtk", "xdmf", "xmf", "med", "hmf", "dat", "tec", "xml", "VTU"]
TRIANGLES_ALONE = ["inp", "stl", "ply", "obj", "off", "mesh", "exo", "vol", "avs", "mdpa"]


@pytest.mark.parametrize("ending", HOLDS_LAYERS)
def test_formats_that_hold_the_layers_keep_them(tmp_path, ending):
    write_planar_mesh(two_triangles(), tmp_path / f"mesh.{ending}")
    assert read_planar_mesh(tmp_path / f"mesh.{ending}").same_as(two_triangles())


@pytest.mark.parametrize("ending", TRIANGLES_ALONE)
def test_formats_that_cannot_hold_the_layers_are_refused(tmp_path, ending):
    with pytest.raises(InputError, match=rf"{ending}: cannot hold which layers .* of \.msh, "):
        write_planar_mesh(two_triangles(), tmp_path / f"mesh.{ending}")
    assert list(tmp_path.iterdir()) == []
    bare = PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [0, 0])
    with pytest.raises(InputError, match=r"cannot hold which layers"):
        write_planar_mesh(bare, tmp_path / f"mesh.{ending}")
    whole = PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 1])
    write_planar_mesh(whole, tmp_path / f"mesh.{ending}")
    assert read_planar_mesh(tmp_path / f"mesh.{ending}").areas.sum() == pytest.approx(1.0)


@pytest.mark.parametrize(
    "ending", ["cgns", "dgf", "su2", "nas", "bdf", "h5m", "svg", "ugrid", "xyz"]
)
def test_formats_that_come_out_wrong_are_not_written(tmp_path, ending):
    whole = PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 1])
    message = r"(cannot be written|holds volume, no triangles), expected an ending of \.avs, "
    with pytest.raises(InputError, match=message):
        write_planar_mesh(whole, tmp_path / f"mesh.{ending}")


@pytest.mark.parametrize("ending", ["ele", "node", "wkt", "svg", "f3grid"])
def test_formats_of_no_triangles_are_refused_and_not_waited_for(tmp_path, ending):
    (tmp_path / f"mesh.{ending}").write_text("")
    with pytest.raises(InputError, match="expected a format of triangles"):
        read_planar_mesh(tmp_path / f"mesh.{ending}")


def test_files_of_other_cells_or_of_no_plane_are_refused(tmp_path):
    path, triangles = tmp_path / "mesh.vtk", np.array([[0, 1, 2], [0, 2, 3]])
    write_file(path, SQUARE, [("quad", np.array([[0, 1, 2, 3]]))])
    with pytest.raises(InputError, match=r"mesh\.vtk: holds quad cells, expected .* of 3 nodes"):
        read_planar_mesh(path)
    write_file(path, np.column_stack([SQUARE, [0, 0, 0, 0.1]]), [("triangle", triangles)])
    with pytest.raises(InputError, match=r"its z goes from 0 to 0.1 m, expected a plane"):
        read_planar_mesh(path)
    write_file(path, np.column_stack([SQUARE, [0, 0, 0, np.nan]]), [("triangle", triangles)])
    with pytest.raises(InputError, match=r"node 3 lies at .*nan"):
        read_planar_mesh(path)


def test_files_that_hold_no_planar_mesh_are_named(tmp_path):
    (tmp_path / "a.vtk").write_text("nonsense")
    for name in ("a.vtk", "missing.vtk", "mesh.unknown"):
        with pytest.raises(InputError, match=f"mesh file .*{name}"):
            read_planar_mesh(tmp_path / name)
    with pytest.raises(InputError, match="cannot be written"):
        write_planar_mesh(two_triangles(), tmp_path / "mesh.unknown")


def test_the_rim_is_the_outer_boundary_alone():
    mesh = grid_mesh(frame(4, 3), origin=(5.0, 7.0))
    on_hole = [[6.0, 8.0], [6.0, 9.0], [7.0, 8.0], [7.0, 9.0], [8.0, 8.0], [8.0, 9.0]]
    inner = np.setdiff1d(np.unique(mesh.boundary_edges), mesh.rim_nodes)
    assert sorted(mesh.points[inner].tolist()) == on_hole
    assert len(mesh.rim_nodes) == len(mesh.points) - len(inner)


def test_the_centre_is_that_of_the_area():
    corner = grid_mesh([(0, 0), (1, 0), (0, 1)], origin=(5.0, 7.0))
    assert corner.centroid == pytest.approx([5 + 5 / 6, 7 + 5 / 6])
    assert corner.points[corner.centre_node].tolist() == [6.0, 8.0]


def test_the_centre_of_a_sheet_about_the_origin_has_no_round_off():
    mesh = grid_mesh(rectangle(6, 6), origin=(-3.0, -3.0))
    turned = mesh.points @ [[np.cos(0.3), np.sin(0.3)], [-np.sin(0.3), np.cos(0.3)]]
    assert mesh.with_points(turned).centroid.tolist() == [0.0, 0.0]


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.8])
@pytest.mark.parametrize("ending", ["msh", "vtu", "vtk", "xml", "med", "xdmf", "vol"])
def test_a_mesh_file_that_is_cut_off_is_one_error(tmp_path, ending, share):
    whole = PlanarMesh(SQUARE, [[0, 1, 2], [0, 2, 3]], [1, 1])
    path = tmp_path / f"mesh.{ending}"
    write_planar_mesh(whole, path)
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    with pytest.raises(InputError, match=rf"^mesh file .*mesh\.{ending}: ") as caught:
        read_planar_mesh(path)
    assert "\n" not in str(caught.value)


def test_a_mesh_file_that_keeps_its_reader_busy_is_given_up(tmp_path):
    """meshio looks for ever for the end of a Tecplot file that is cut off."""
    path = tmp_path / "mesh.dat"
    write_planar_mesh(two_triangles(), path)
    path.write_text(path.read_text()[:-20])
    with pytest.raises(InputError, match=r"reading it takes longer than"):
        read_mesh_file(path, shortest_time=0.2)
