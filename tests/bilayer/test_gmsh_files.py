"""Files of gmsh, as gmsh itself writes them: which layers lie on their triangles."""

from pathlib import Path

import meshio
import numpy as np
import pytest

from bilayer import InputError, read_planar_mesh, write_planar_mesh
from bilayer.mesh.gmsh_session import gmsh_session
from bilayer.mesh.planar import PlanarMesh

FILM = frozenset({"base"}), frozenset({"base", "film"}), frozenset({"base", "top"}), frozenset(
    {"base", "film", "top"}
)  # fmt: skip
NO_CARRIER = frozenset(), frozenset({"left"}), frozenset({"right"}), frozenset({"left", "right"})


def draw_disc_in_ring(geo):
    """Draw a square of 20 mm in one of 40 mm around a point that belongs to neither."""
    centre = geo.addPoint(0, 0, 0)
    loops, corners = [], []
    for radius in (0.02, 0.01):
        ends = [geo.addPoint(x * radius, y * radius, 0, 0.02) for x, y in SQUARE]
        arcs = [geo.addCircleArc(ends[k], centre, ends[(k + 1) % 4]) for k in range(4)]
        loops.append(geo.addCurveLoop(arcs))
        corners.append(arcs)
    ring, disc = geo.addPlaneSurface(loops), geo.addPlaneSurface(loops[1:])
    geo.synchronize()
    return ring, disc, corners[0]


SQUARE = [(1, 0), (0, 1), (-1, 0), (0, -1)]


@pytest.fixture
def save(tmp_path):
    """Write a ring and a disc in it with physical groups of RING, DISC and RIM; give the file."""

    def write(groups, version=4.1, everything=False, binary=False):
        path = tmp_path / "drawn.msh"
        options = {
            "Mesh.MshFileVersion": version,
            "Mesh.SaveAll": int(everything),
            "Mesh.Binary": int(binary),
        }
        with gmsh_session(options) as gmsh:
            ring, disc, rim = draw_disc_in_ring(gmsh.model.geo)
            entities = {"ring": ring, "disc": disc, "rim": rim}
            for tag, (name, members) in groups.items():
                dim = 1 if members == "rim" else 2
                tags = np.hstack([entities[member] for member in members.split()])
                gmsh.model.addPhysicalGroup(dim, tags, tag, name)
            gmsh.model.mesh.generate(2)
            gmsh.write(str(path))
        return path

    return write


def layers_by_radius(mesh):
    """Return the layers in the disc and in the ring around it."""
    inside = np.linalg.norm(mesh.points[mesh.triangles].mean(axis=1), axis=1) < 0.0095
    found = []
    for part in (inside, ~inside):
        (number,) = set(mesh.region[part].tolist())
        found.append(set(mesh.layer_sets[number]))
    return found


BOTH, ALONE = {"substrate", "kirigami"}, {"substrate"}
FORMS = [(2.2, False), (2.2, True), (4.1, False), (4.1, True)]


@pytest.mark.parametrize(("version", "binary"), FORMS)
@pytest.mark.parametrize("everything", [False, True])
def test_no_group_is_all_layers(save, version, binary, everything):
    """In version 2.2 it is written as group 0."""
    assert layers_by_radius(read_planar_mesh(save({}, version, everything, binary))) == [BOTH, BOTH]


NAMED = {
    "a layer, and bare": {5: ("bare", "ring"), 6: ("kirigami", "disc")},
    "a layer, and the one below": {5: ("substrate", "ring"), 6: ("kirigami", "disc")},
    "both layers by one name": {5: ("substrate", "ring"), 6: ("kirigami+substrate", "disc")},
    "a group for each layer": {5: ("substrate", "ring disc"), 6: ("kirigami", "disc")},
    "capitals": {5: ("Bare", "ring"), 6: ("KIRIGAMI", "disc")},
    "a rim, too": {3: ("rim", "rim"), 5: ("bare", "ring"), 6: ("kirigami", "disc")},
    "a rim of the layer's name": {
        3: ("kirigami", "rim"), 5: ("bare", "ring"), 6: ("kirigami", "disc"),
    },
    "a group of all, too": {
        4: ("sheet", "ring disc"), 5: ("bare", "ring"), 6: ("kirigami", "disc"),
    },
    "tags that would be regions": {1: ("bare", "ring"), 2: ("kirigami", "disc")},
}  # fmt: skip


@pytest.mark.parametrize("groups", NAMED.values(), ids=NAMED)
@pytest.mark.parametrize(("version", "binary"), FORMS)
def test_names_tell_the_layers(save, groups, version, binary):
    mesh = read_planar_mesh(save(groups, version, binary=binary))
    assert layers_by_radius(mesh) == [BOTH, ALONE]


PARTLY = {
    "the layer has a group": ({6: ("kirigami", "disc")}, [BOTH, ALONE]),
    "bare has a group": ({5: ("bare", "ring")}, [BOTH, ALONE]),
    "tag 1": ({1: ("", "disc")}, [BOTH, ALONE]),
    "the layer everywhere": ({6: ("kirigami", "ring disc")}, [BOTH, BOTH]),
    "bare everywhere": ({6: ("bare", "ring disc")}, [ALONE, ALONE]),
    "something else everywhere": ({6: ("sheet", "ring disc")}, [BOTH, BOTH]),
    "a tag everywhere": ({7: ("", "ring disc")}, [BOTH, BOTH]),
    "only the rim": ({7: ("rim", "rim")}, [BOTH, BOTH]),
}


@pytest.mark.parametrize(("groups", "layers"), PARTLY.values(), ids=PARTLY)
@pytest.mark.parametrize("binary", [False, True])
def test_all_elements_saved_with_groups_of_some(save, groups, layers, binary):
    """Mesh.SaveAll: surfaces, curves and points of no group beside those of one."""
    mesh = read_planar_mesh(save(groups, everything=True, binary=binary))
    assert layers_by_radius(mesh) == layers


REFUSED = {
    "names of no layer": (
        {1: ("aluminium", "ring"), 2: ("rubber", "disc")},
        r"drawn.msh: its physical group 'aluminium': expected the name of a layer \(kirigami, ",
    ),
    "a name almost right": (
        {1: ("bare", "ring"), 2: ("kirigame", "disc")}, r"'kirigame'.*; did you mean 'kirigami'\?",
    ),
    "tags without names": (
        {1: ("", "ring"), 2: ("", "disc")},
        r"groups 1, 2 have no names, .* as tags 0 \(substrate\), 1 \(kirigami\+substrate\)$",
    ),
    "one named, one not": ({1: ("", "ring"), 2: ("kirigami", "disc")}, "its physical group '1'"),
    "a layer without a name": ({2: ("kirigami+", "disc"), 3: ("bare", "ring")}, "'kirigami\\+'"),
}  # fmt: skip


@pytest.mark.parametrize(("groups", "message"), REFUSED.values(), ids=REFUSED)
def test_groups_of_no_layer_are_refused(save, groups, message):
    with pytest.raises(InputError, match=message):
        read_planar_mesh(save(groups))


def test_groups_that_version_2_left_out_are_missed(save):
    """gmsh writes group 0 for every element there if all are saved."""
    path = save(NAMED["a layer, and bare"], 2.2, everything=True)
    with pytest.raises(InputError, match="though it names 'bare', 'kirigami'"):
        read_planar_mesh(path)


def test_triangles_in_no_group_beside_layers_and_bare_are_refused(save):
    groups = {1: ("base", "disc"), 2: ("rim", "rim")}
    path = save(groups, everything=True)
    assert layers_by_radius(read_planar_mesh(path, FILM))[0] == {"base"}
    with pytest.raises(InputError, match=r"of its \d+ triangles are in no physical group"):
        read_planar_mesh(save({1: ("left", "disc")}, everything=True), NO_CARRIER)


@pytest.mark.parametrize(
    ("sets", "disc", "ring", "layers"),
    [
        (FILM, "film", "top", [{"base", "film"}, {"base", "top"}]),
        (FILM, "film+top", "base", [{"base", "film", "top"}, {"base"}]),
        (FILM, "top + film", "bare", [{"base", "film", "top"}, {"base"}]),
        (NO_CARRIER, "left", "right+left", [{"left"}, {"left", "right"}]),
    ],
)
def test_layers_of_other_sheets(save, sets, disc, ring, layers):
    path = save({1: (disc, "disc"), 2: (ring, "ring")})
    assert layers_by_radius(read_planar_mesh(path, sets)) == layers


def test_there_is_no_bare_sheet_without_a_whole_layer(save):
    with pytest.raises(InputError, match=r"'bare': expected the name of a layer \(left, right\),"):
        read_planar_mesh(save({1: ("bare", "disc"), 2: ("left", "ring")}), NO_CARRIER)


def two_triangles(region, sets=FILM):
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    return PlanarMesh(points, [[0, 1, 2], [0, 2, 3]], region, sets)


@pytest.mark.parametrize("region", [(0, 0), (0, 1), (3, 3), (1, 2), (2, 2)])
def test_what_is_written_is_read_also_by_gmsh(tmp_path, region):
    mesh, path = two_triangles(region), tmp_path / "m.msh"
    write_planar_mesh(mesh, path)
    assert read_planar_mesh(path, FILM).same_as(mesh)
    with gmsh_session({"Mesh.MshFileVersion": 4.1}) as gmsh:
        gmsh.merge(str(path))
        gmsh.write(str(tmp_path / "again.msh"))
    again = read_planar_mesh(tmp_path / "again.msh", FILM)
    assert sorted(again.region) == sorted(region)


def test_an_older_file_of_ours_has_the_regions_as_tags(tmp_path):
    mesh = two_triangles((0, 1))
    points = np.pad(mesh.points, ((0, 0), (0, 1)))
    for tags in ([0, 1], [3, 2]):
        data = {"gmsh:physical": [np.array(tags)], "gmsh:geometrical": [np.array(tags)]}
        file = meshio.Mesh(points, [("triangle", mesh.triangles)], cell_data=data)
        file.write(tmp_path / "old.msh", file_format="gmsh22")
        assert read_planar_mesh(tmp_path / "old.msh", FILM).region.tolist() == tags


def test_a_sheet_seen_from_below_is_turned_over(tmp_path):
    mesh = two_triangles((0, 1))
    points = np.pad(mesh.points, ((0, 0), (0, 1)))
    file = meshio.Mesh(points, [("triangle", mesh.triangles[:, ::-1])])
    file.write(tmp_path / "m.vtk")
    assert (read_planar_mesh(tmp_path / "m.vtk").areas > 0).all()


DAMAGED = {
    "a future one": ("4.1 0 8", "5.0 0 8", "is of gmsh's version 5.0, expected 2.2 or 4.1"),
    "no end": ("$EndEntities", "", "cannot be read"),
    "many points": ("$Entities\n9", "$Entities\n999999999999", "cannot be read"),
    "a text": ("$Entities\n9", "$Entities\nx", "cannot be read"),
    "partitioned": ("$Entities", "$PartitionedEntities\n$EndPartitionedEntities\n$Entities",
                    "is partitioned, expected the whole mesh in one part"),
    "a node that is not there": ("$Elements", "$Elements\n1 1 1 1\n2 1 2 1\n1 900 901 902\n"
                                 "$EndElements\n$Comment", "cannot be read|has node"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), DAMAGED.values(), ids=DAMAGED)
def test_damaged_files_are_one_error(save, old, new, message):
    path: Path = save(NAMED["a layer, and bare"])
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(InputError, match=rf"^mesh file .*drawn.msh: .*({message})"):
        read_planar_mesh(path)


@pytest.mark.parametrize(
    ("sets", "layers"),
    [
        ({"KIRIGAMI": "disc"}, [BOTH, ALONE]),
        ({"Surface1": "ring", "Surface2": "disc"}, [BOTH, BOTH]),
        ({"bare": "ring", "Surface2": "disc"}, [BOTH, ALONE]),
        ({"substrate": "ring disc", "kirigami": "disc", "Surface1": "ring"}, [BOTH, ALONE]),
    ],
)
def test_sets_of_abaqus_are_read_by_the_layers_names(save, tmp_path, sets, layers):
    drawn = read_planar_mesh(save(NAMED["a layer, and bare"]))
    parts = {"disc": np.flatnonzero(drawn.region == 1), "ring": np.flatnonzero(drawn.region == 0)}
    members = {
        name: [np.sort(np.concatenate([parts[part] for part in names.split()]))]
        for name, names in sets.items()
    }
    points = np.pad(drawn.points, ((0, 0), (0, 1)))
    file = meshio.Mesh(points, [("triangle", drawn.triangles)], cell_sets=members)
    file.write(tmp_path / "m.inp")
    assert layers_by_radius(read_planar_mesh(tmp_path / "m.inp")) == layers


def test_version_4_0_is_named(save):
    with pytest.raises(InputError, match=r"is of gmsh's version 4, expected 2.2 or 4.1"):
        read_planar_mesh(save({}, version=4.0))
