"""Supports and loads in a specimen and its file, and the parts of the mesh that they mean."""

import math

import numpy as np
import pytest

from bilayer import InputError, Limit, Load, Part, Support, generate_mesh, parse_specimen
from bilayer.mesh.parts import (
    check_pressed,
    clamped_edges,
    edges_of,
    faces_of,
    node_shares,
    nodes_of,
    supported_coordinates,
)
from bilayer.results.table import milestone_text
from bilayer.specimen.support import choose_nodes_inside, pins_besides
from bilayer.specimen.toml import specimen_to_toml

PLATE = """
[specimen]
name = "plate"
outline = { shape = "rectangle", width = "40 mm", height = "20 mm" }
[[layers]]
name = "plate"
thickness = "0.2 mm"
material = "plastic"
[materials.plastic]
law = "linear"
young_modulus = "1 MPa"
poisson_ratio = 0.3
[mesh]
size = "4 mm"
"""
HELD = """
[supports.left]
where = { on = "rim", x = "<= -20 mm" }
kind = "clamped"
[supports.right]
where = { on = "rim", x = ">= 20 mm" }
kind = "guided"
[loads.blow]
pressure = ["0 Pa", "50 Pa", 20]
[loads.poke]
where = { point = ["0 mm", 0] }
direction = "-z"
displacement = ["free", "1 mm", "2 mm"]
[loads.pull]
where = { line = [["5 mm", "-10 mm"], ["5 mm", "10 mm"]] }
direction = [3, 0, 4]
line_force = "1 N/m"
"""


@pytest.fixture(scope="module")
def plate():
    return parse_specimen(PLATE + HELD)


@pytest.fixture(scope="module")
def mesh(plate):
    return generate_mesh(plate)


def test_a_file_with_supports_and_loads_reads_back_as_the_same(plate):
    assert parse_specimen(specimen_to_toml(plate)) == plate
    assert plate.supports[0] == Support(
        "left", "clamped", Part("rim", (Limit("x", "<=", -0.02),)), "xyz"
    )
    assert plate.loads[2] == Load(
        "pull", "line_force", (1.0,), Part(line=((0.005, -0.01), (0.005, 0.01))), (0.6, 0.0, 0.8)
    )


def test_milestones_are_the_prestretch_and_each_load(plate):
    assert len(plate.prestretch.milestones) == 3
    assert plate.milestones[1] == (1.0, 1.0, 50.0, 0.001, 1.0)
    assert math.isnan(plate.milestones[0][3])
    assert milestone_text(plate, plate.milestones[0]) == "1, blow 0 Pa, poke free, pull 1 N/m"
    assert milestone_text(plate, plate.milestones[1]) == "1, blow 50 Pa, poke 1 mm, pull 1 N/m"
    single = plate.at_milestone(plate.milestones[0])
    assert [load.values for load in single.loads] == [(0.0,), ("free",), (1.0,)]


def test_a_short_file_may_have_them_too():
    short = parse_specimen(
        specimen_to_toml(
            parse_specimen("""
            [specimen]
            outer_radius = 0.04
            [substrate]
            thickness = 0.001
            young_modulus = 1e5
            poisson_ratio = 0.49
            [kirigami]
            thickness = 0.001
            young_modulus = 3e5
            poisson_ratio = 0.49
            [prestretch]
            milestones = [1.03, 1.06]
            [supports.rim]
            kind = "hinged"
            [loads.press]
            force = ["0 N", "-0.01 N"]
            """)
        )
    )
    assert short.milestones == ((1.03, 1.03, 0.0), (1.06, 1.06, -0.01))
    assert short.supports[0].part == Part("rim")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('kind = "guided"', 'kind = "glued"'), r"supports.right.kind = 'glued': expected one of"),
        (('kind = "clamped"', 'kind = "clamped"\naxes = "x"'), "supports.left.axes = 'x'"),
        (('x = ">= 20 mm"', 'x = "20 mm"'), "supports.right.where.x = '20 mm': expected such as"),
        (('on = "rim", x = ">=', 'on = "rimm", x = ">='), "where.on = 'rimm'.*did you mean 'rim'"),
        (("pressure", "presure"), "loads.blow.presure: unknown key.*did you mean 'pressure'"),
        (('"50 Pa"', '"50 N"'), "loads.blow.pressure = '50 N': expected a modulus"),
        (('"50 Pa", 20', '"50 Pa"'), "loads.blow.pressure: has 2 values and loads.poke"),
        (('"-z"', '"up"'), "loads.poke.direction = 'up'"),
        (("[3, 0, 4]", "[0, 0, 0]"), "loads.pull.direction"),
        (('"0 Pa", "50 Pa", 20', '"free", 1, 2'), "loads.blow.pressure = 'free'"),
        (("[loads.pull]", "[loads.steps]"), "loads.steps: expected another name"),
        (('line_force = "1 N/m"', 'pressure = "1 Pa"'), "loads.pull.direction: a pressure has"),
        (("[loads.poke]", '[loads."a b"]'), "loads.'a b': expected a name"),
        (('["0 mm", 0]', '["0 N", 0]'), r"^loads.poke.where.point = '0 N': expected a length"),
        (('[["5 mm", "-10 mm"], ["5 mm", "10 mm"]]', "[[0, 0], [0, 0]]"), "two different points"),
        (('["0 mm", 0]', '["1 m", 0]'), r"loads.poke.where = the point .1000, 0. mm: lies out"),
        (('["5 mm", "10 mm"]]', '["5 mm", 0]]'), r"ends within the sheet at \(5, 0\) mm"),
        (('kind = "guided"', 'kind = "guided"\naxes = ""'), "supports.right.axes = ''"),
        (('"50 Pa"', '"50 MPa"'), "loads.blow.pressure = 5e.07 Pa: expected at most 1.25e.06 Pa"),
        (('"2 mm"]', '"2 m"]'), "loads.poke.displacement = 2 m: expected at most 0.16 m"),
        (('["0 mm", 0]', "[0]"), r"loads.poke.where.point = \[0\]: expected \[x, y\]"),
    ],
)  # fmt: skip
def test_bad_files_are_named(change, message):
    assert change[0] in HELD
    with pytest.raises(InputError, match=message) as caught:
        parse_specimen(PLATE + HELD.replace(*change))
    assert "\n" not in str(caught.value)


def test_loads_and_prestretches_are_as_many():
    text = PLATE + HELD + "[prestretch]\nmilestones = [1.0, 1.1]\n"
    with pytest.raises(InputError, match=r"prestretch.milestones: has 2 values and loads.blow"):
        parse_specimen(text)


def test_parts_are_the_nodes_and_edges_they_say(plate, mesh):
    left, right = (support.part for support in plate.supports)
    assert np.allclose(mesh.points[nodes_of(left, mesh, "")][:, 0], -0.02)
    edges = edges_of(right, mesh, "")
    assert np.linalg.norm(np.diff(mesh.points[edges], axis=1)) > 0
    lengths = np.linalg.norm(np.diff(mesh.points[edges], axis=1)[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(0.02)
    held = supported_coordinates(plate, mesh)
    assert np.bincount(held[:, 1]).tolist() == [
        len(nodes_of(left, mesh, "")), len(nodes_of(left, mesh, "")),
        len(nodes_of(left, mesh, "")) + len(nodes_of(right, mesh, "")),
    ]  # fmt: skip
    assert len(clamped_edges(plate, mesh)) == len(edges) + len(edges_of(left, mesh, ""))


def test_a_line_is_drawn_into_the_mesh(plate, mesh):
    edges = edges_of(plate.loads[2].part, mesh, "")
    lengths = np.linalg.norm(np.diff(mesh.points[edges], axis=1)[:, 0], axis=1)
    assert lengths.sum() == pytest.approx(0.02)
    assert np.allclose(mesh.points[edges][:, :, 0], 0.005)


def test_an_even_force_is_shared_by_area_and_by_length(mesh):
    for part in (Part(), Part("rim"), Part(limits=(Limit("r", "<=", 0.009),))):
        nodes, shares = node_shares(part, mesh, "")
        assert shares.sum() == pytest.approx(1)
        assert (shares > 0).all()
    nodes, shares = node_shares(Part(), mesh, "")
    assert shares @ mesh.points[nodes] == pytest.approx([0, 0], abs=1e-5)
    assert node_shares(Part(point=(0.02, 0.01)), mesh, "")[1].tolist() == [1.0]
    assert len(faces_of(Part(limits=(Limit("x", ">=", 0.0),)), mesh, "")) < len(mesh.triangles)


def test_parts_that_are_nowhere_are_named(mesh):
    with pytest.raises(InputError, match=r"supports.x.where = the edges of holes: no node"):
        nodes_of(Part("holes"), mesh, "supports.x.where")
    with pytest.raises(InputError, match="a line runs from edge to edge"):
        nodes_of(Part(line=((0.001, 0.0011), (0.002, 0.0013))), mesh, "loads.x.where")


def test_a_pressure_needs_a_held_edge(plate, mesh):
    with pytest.raises(
        InputError, match=r"loads.blow.where = the sheet: its edge is not held in z"
    ):
        check_pressed(plate, mesh)


def test_pins_take_away_what_supports_leave(plate, mesh):
    nodes = choose_nodes_inside(mesh.points)
    none = np.empty((0, 2), dtype=np.int64)
    assert len(pins_besides(mesh.points, none, none, nodes)) == 6
    held, clamped = supported_coordinates(plate, mesh), clamped_edges(plate, mesh)
    assert len(pins_besides(mesh.points, held, clamped, nodes)) == 0
    level = held[held[:, 1] == 2]
    assert pins_besides(mesh.points, level, none, nodes)[:, 1].tolist() == [0, 1, 1]
    right = supported_coordinates(parse_specimen(PLATE + """
        [prestretch]
        milestones = [1.0]
        [supports.right]
        where = { on = "rim", x = ">= 20 mm" }
        kind = "hinged"
        """), mesh)  # fmt: skip
    hinge = pins_besides(mesh.points, right, none, nodes)
    assert hinge[:, 1].tolist() == [2]
    edges = edges_of(Part("rim", (Limit("x", ">=", 0.02),)), mesh, "")
    assert len(pins_besides(mesh.points, right, edges, nodes)) == 0
