"""Meshes of any outline and pattern: areas of every layer, cut edges, sizes; what agrees."""

from dataclasses import replace

import gmsh
import numpy as np
import pytest
import shapely
from sheets import OUTLINES, PATTERNS, bilayer, circle, trilayer

from bilayer import (
    CutPattern,
    InputError,
    MeshSize,
    PlanarMesh,
    Polygons,
    Specimen,
    generate_mesh,
    paper_specimen,
    read_planar_mesh,
    solve,
    write_planar_mesh,
)
from bilayer.mesh.agreement import check_agreement
from bilayer.mesh.generation import estimated_triangles
from bilayer.mesh.gmsh_session import gmsh_session

CUT = CutPattern(5, 0.006, 0.4)


def shape_quality(mesh):
    """Of each triangle: 1 for an equilateral one, 0 for a line."""
    corners = mesh.points[mesh.triangles]
    sides = corners - np.roll(corners, 1, axis=1)
    return 4 * np.sqrt(3) * mesh.areas / (sides**2).sum(axis=(1, 2))


def covered(mesh, name):
    return mesh.areas[mesh.faces_of(name)].sum()


@pytest.mark.parametrize("outline", OUTLINES)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_every_layer_has_its_area_on_a_sound_mesh(outline, pattern):
    """Chords of arcs cost area: of circles of the size of the mesh 3 % at most."""
    sheet = bilayer(OUTLINES[outline], PATTERNS[pattern])
    mesh = generate_mesh(sheet)
    assert covered(mesh, "substrate") == pytest.approx(sheet.outline.area, rel=4e-3)
    expected = shapely.area(sheet.region_of("kirigami"))
    assert covered(mesh, "kirigami") == pytest.approx(expected, rel=0.03)
    assert shape_quality(mesh).min() > 0.2
    assert len(mesh.triangles) == pytest.approx(estimated_triangles(sheet), rel=0.35)
    check_agreement(sheet, mesh)


@pytest.mark.parametrize("pattern", ["cross", "turned cross", "cut polygons"])
def test_no_triangle_crosses_a_straight_cut(pattern):
    sheet = bilayer(OUTLINES["rectangle"], Polygons(circle_of_squares(), "cut"))
    if pattern != "cut polygons":
        sheet = sheet.with_layer("kirigami", pattern=PATTERNS[pattern])
    mesh = generate_mesh(sheet)
    region = sheet.region_of("kirigami")
    triangles = shapely.polygons(mesh.points[mesh.triangles[mesh.faces_of("kirigami")]])
    assert shapely.covers(region.buffer(1e-8), triangles).all()
    assert covered(mesh, "kirigami") == pytest.approx(region.area, rel=1e-6)


def circle_of_squares():
    return [circle(x, y, 0.004, corners=4) for x, y in ((0.01, 0.0), (-0.005, 0.01))]


def test_layers_with_patterns_of_their_own_make_all_sets_of_layers():
    sheet = trilayer(OUTLINES["ellipse"], CUT, PATTERNS["cross"])
    mesh = generate_mesh(sheet)
    assert set(mesh.region) == {0, 1, 2, 3}
    lower, upper = sheet.region_of("lower"), sheet.region_of("upper")
    both = mesh.areas[mesh.region == 3].sum()
    assert both == pytest.approx(shapely.intersection(lower, upper).area, rel=2e-3)
    assert covered(mesh, "lower") == pytest.approx(lower.area, rel=4e-3)
    assert covered(mesh, "upper") == pytest.approx(upper.area, rel=4e-3)


def nearly_coincident(apart):
    """A trilayer whose upper patterns have cutouts that begin `apart` from each other, m."""
    inner = CutPattern(5, 0.006 + apart, 0.4)
    return trilayer(lower=inner, upper=CutPattern(5, 0.006, 0.4))


def test_edges_that_nearly_coincide_are_one():
    exact, near = (generate_mesh(nearly_coincident(apart)) for apart in (0.0, 3e-6))
    sides = near.points[near.triangles] - near.points[np.roll(near.triangles, 1, axis=1)]
    assert np.linalg.norm(sides, axis=2).min() > 5e-4
    assert len(near.triangles) == pytest.approx(len(exact.triangles), rel=0.05)
    assert covered(near, "lower") == pytest.approx(covered(exact, "lower"), rel=1e-3)


def test_a_slit_too_narrow_for_the_mesh_is_refused_with_its_place():
    halves = Polygons(
        tuple(((s * 5e-7, -0.01), (s * 0.01, -0.01), (s * 0.01, 0.01), (s * 5e-7, 0.01))
              for s in (-1, 1))
    )  # fmt: skip
    with pytest.raises(InputError, match=r"two edges 1(\.\d)? um from each other at x, y = "):
        generate_mesh(bilayer(pattern=halves))


def test_a_trilayer_of_one_pattern_has_the_mesh_of_the_bilayer():
    two, three = generate_mesh(bilayer(pattern=CUT)), generate_mesh(trilayer(lower=CUT, upper=CUT))
    assert np.array_equal(two.points, three.points)
    assert np.array_equal(two.triangles, three.triangles)
    assert np.array_equal(3 * two.region, three.region)


def test_where_no_layer_lies_there_is_no_sheet():
    sheet = bilayer(pattern=CUT)
    lattice = Specimen(sheet.outline, sheet.layers[1:], sheet.prestretch, sheet.mesh)
    mesh = generate_mesh(lattice)
    assert mesh.areas.sum() == pytest.approx(lattice.sheet.area, rel=4e-3)
    assert set(mesh.region) == {1}


@pytest.mark.parametrize("pattern", ["cross", "kept polygons"])
def test_the_corner_size_is_kept_at_the_cuts_corners_alone(pattern):
    coarse = bilayer(OUTLINES["rectangle"], PATTERNS[pattern])
    fine = replace(coarse, mesh=MeshSize(0.0025, 0.0004))
    corner = {"cross": (0.00165, 0.00165), "kept polygons": (-0.004, -0.004)}[pattern]

    def shortest_edge(mesh):
        ends = mesh.points[mesh.edges]
        near = np.linalg.norm(ends.mean(axis=1) - corner, axis=1) < 6e-4
        return np.linalg.norm(ends[near, 1] - ends[near, 0], axis=1).min()

    mesh = generate_mesh(fine)
    assert (
        shortest_edge(mesh)
        < 0.0006
        < shortest_edge(generate_mesh(replace(coarse, mesh=MeshSize(0.0012))))
    )
    assert len(mesh.triangles) == pytest.approx(estimated_triangles(fine), rel=0.35)
    ends = mesh.points[mesh.boundary_edges]
    assert np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max() > 0.002


def test_the_centre_is_a_node():
    for name in ("ellipse", "rectangle", "hexagon"):
        mesh = generate_mesh(bilayer(OUTLINES[name], PATTERNS["cross"]))
        assert np.linalg.norm(mesh.points[mesh.centre_node]) < 1e-12


def test_a_mesh_file_of_any_sheet_is_read_with_its_layers(tmp_path):
    sheet = trilayer(OUTLINES["ellipse"], CUT, PATTERNS["cross"])
    mesh = generate_mesh(sheet)
    for ending in ("msh", "vtu"):
        write_planar_mesh(mesh, tmp_path / f"m.{ending}")
        assert read_planar_mesh(tmp_path / f"m.{ending}", sheet.layer_sets).same_as(mesh)


def test_a_mesh_keeps_arrays_of_its_own():
    mesh = generate_mesh(bilayer())
    given = [np.array(array) for array in (mesh.points, mesh.triangles, mesh.region)]
    own = PlanarMesh(*given)
    given[0] += 1.0
    given[2][:] = 0
    assert own.same_as(mesh)
    with pytest.raises(ValueError, match="read-only"):
        own.points[0] = 0.0


def test_layers_of_a_mesh_are_those_of_its_sets():
    points, triangles = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]), [[0, 1, 2], [0, 2, 3]]
    mesh = PlanarMesh(points, triangles, [1, 2], [set(), {"a"}, {"a", "b"}])
    assert mesh.faces_of("a").tolist() == [0, 1]
    assert mesh.faces_of("b").tolist() == [1]
    assert mesh.faces_of("c").tolist() == []
    with pytest.raises(InputError, match="triangle 0 has region = 0: expected 1 or 2"):
        PlanarMesh(points, triangles, [0, 2], [set(), {"a"}, {"a", "b"}])


def test_gmsh_is_left_as_it_was_found():
    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("mine")
        gmsh.model.geo.addPoint(0, 0, 0, 1.0)
        gmsh.model.geo.synchronize()
        gmsh.option.setNumber("Mesh.Algorithm", 5)
        gmsh.option.setNumber("Mesh.MeshSizeFactor", 3)
        mesh = generate_mesh(bilayer())
        assert (gmsh.model.getCurrent(), gmsh.model.getEntities(0)) == ("mine", [(0, 1)])
        assert gmsh.option.getNumber("Mesh.Algorithm") == 5
        assert gmsh.option.getNumber("Mesh.MeshSizeFactor") == 3
        with pytest.raises(RuntimeError), gmsh_session():
            raise RuntimeError
        assert gmsh.model.getCurrent() == "mine"
        gmsh.model.remove()
    finally:
        gmsh.finalize()
    assert generate_mesh(bilayer()).same_as(mesh)
    assert not gmsh.isInitialized()


SHEETS = {
    "disc": bilayer(pattern=CUT),
    "square": bilayer(OUTLINES["rectangle"], PATTERNS["cross"]),
    "holes": bilayer(OUTLINES["holes"], PATTERNS["cross"]),
}


@pytest.mark.parametrize(
    ("meshed", "asked", "message"),
    [
        ("disc", replace(SHEETS["disc"], outline=replace(OUTLINES["disc"], radius=0.0201)),
         r"lies 0.0001 m from the specimen's outline, expected specimen.outer_radius = 0.0201 m"),
        ("disc", replace(SHEETS["disc"], outline=replace(OUTLINES["disc"], radius=0.0199)),
         "expected specimen.outer_radius = 0.0199 m"),
        ("disc", SHEETS["square"], "rim .* expected a Rectangle of the characteristic length"),
        ("square", bilayer(OUTLINES["stadium"]), "expected a Rectangle of the characteristic"),
        ("holes", bilayer(replace(OUTLINES["holes"], holes=())), "lies .* from the specimen's"),
        ("square", bilayer(OUTLINES["rounded"]), "outline, expected a Rectangle"),
        ("disc", bilayer(pattern=replace(CUT, strips=6)), "the layer 'kirigami' .* is wrong"),
        ("disc", bilayer(pattern=replace(CUT, cutout_angle=0.7)), "lies on triangle .* not lie"),
        ("disc", bilayer(pattern=replace(CUT, cutout_angle=0.1)), "is missing on triangle"),
        ("square", bilayer(OUTLINES["rectangle"], CUT), "the layer 'kirigami'"),
        ("disc", trilayer(lower=CUT, upper=CUT), "has the layer 'kirigami', expected .*: lower,"),
    ],
)  # fmt: skip
def test_a_mesh_of_another_specimen_is_refused(meshed, asked, message):
    mesh = generate_mesh(SHEETS[meshed])
    with pytest.raises(InputError, match=message) as caught:
        check_agreement(asked, mesh)
    assert "\n" not in str(caught.value)


def test_an_outline_with_a_hole_is_no_mesh_without_it():
    solid = generate_mesh(bilayer(replace(OUTLINES["holes"], holes=())))
    with pytest.raises(InputError, match="its rim passes the specimen's outline at"):
        check_agreement(bilayer(OUTLINES["holes"]), solid)


def test_the_solvers_refuse_a_mesh_of_another_specimen():
    mesh = generate_mesh(SHEETS["disc"])
    with pytest.raises(InputError, match=r"mesh: the layer 'kirigami'"):
        solve(bilayer(pattern=replace(CUT, strips=6)), "dshell", mesh=mesh)


def test_two_whole_layers_take_a_mesh_with_a_pattern_of_its_own():
    mesh = generate_mesh(SHEETS["disc"])
    check_agreement(bilayer(), mesh)
    with pytest.raises(InputError, match="the layer 'substrate' is missing"):
        check_agreement(
            bilayer(), replace(mesh, layer_sets=[{"kirigami"}, {"kirigami", "substrate"}])
        )


def test_a_coarse_polygon_with_its_corners_on_the_rim_is_a_mesh_of_a_disc():
    square = np.array([[0.0, 0.04], [-0.04, 0.0], [0.0, -0.04], [0.04, 0.0]])
    mesh = PlanarMesh(square, [[0, 1, 2], [0, 2, 3]], [1, 1])
    check_agreement(paper_specimen().with_layer("kirigami", pattern=None), mesh)


PAPER = replace(paper_specimen(), mesh=MeshSize(0.01))
PAPERS_CUT = PAPER.layer("kirigami").pattern
RECTANGLE = replace(bilayer(OUTLINES["rectangle"]), mesh=MeshSize(0.01))
NEARLY = {
    "wider cutouts": PAPER.with_layer("kirigami", pattern=replace(PAPERS_CUT, cutout_angle=0.31)),
    "narrower ones": PAPER.with_layer("kirigami", pattern=replace(PAPERS_CUT, cutout_angle=0.29)),
    "much wider ones": PAPER.with_layer("kirigami", pattern=replace(PAPERS_CUT, cutout_angle=0.5)),
    "shorter cutouts": PAPER.with_layer(
        "kirigami", pattern=replace(PAPERS_CUT, inner_radius=0.009)
    ),
    "a larger disc": replace(PAPER, outline=replace(PAPER.outline, radius=0.0402)),
    "a longer rectangle": replace(
        RECTANGLE, outline=replace(RECTANGLE.outline, width=1.02 * RECTANGLE.outline.width)
    ),
}


@pytest.mark.parametrize("name", NEARLY)
def test_a_coarse_mesh_of_nearly_the_same_specimen_is_refused(name):
    """Its edges are long, and the cuts lie beside them by much less than an edge."""
    meshed = RECTANGLE if name == "a longer rectangle" else PAPER
    mesh = generate_mesh(meshed)
    check_agreement(meshed, mesh)
    with pytest.raises(InputError, match=r"^mesh: .*(no node at the corner|lies .* m from)"):
        check_agreement(NEARLY[name], mesh)


def test_a_mesh_on_which_a_layer_lies_nowhere_is_refused():
    mesh = generate_mesh(PAPER)
    bare = replace(mesh, region=np.zeros_like(mesh.region))
    for specimen in (PAPER, PAPER.with_layer("kirigami", pattern=None)):
        with pytest.raises(InputError, match="'kirigami' lies on none of its triangles"):
            check_agreement(specimen, bare)


def test_half_a_disc_is_no_disc():
    mesh = generate_mesh(PAPER)
    upper = mesh.points[mesh.triangles].mean(axis=1)[:, 1] > 0
    nodes, numbered = np.unique(mesh.triangles[upper], return_inverse=True)
    half = PlanarMesh(mesh.points[nodes], numbered.reshape(-1, 3), mesh.region[upper])
    with pytest.raises(InputError, match="rim"):
        check_agreement(PAPER, half)
