"""Self-contact: sheets that are known to touch themselves or not, and the skin that decides."""

import math
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from made_results import cap_result, small_specimen
from scipy.spatial.transform import Rotation
from shapes import cap, in_plane
from sheets import trilayer

from bilayer import MeshSize, PlanarMesh, Response, generate_mesh, paper_specimen
from bilayer.contact.self_contact import self_contact_gap
from bilayer.contact.skin import BondedBody, Sheet, skin_of
from bilayer.geometry.surface import Surface
from bilayer.results.report import describe_trust, gap_words, result_table

BELOW, ABOVE = 0.6e-3, 1e-3
LENGTH = 0.06


def strip(length=LENGTH, width=0.01, size=0.001, region=1):
    """A rectangle of right triangles, its length along x from 0."""
    columns, rows = round(length / size) + 1, round(width / size) + 1
    x, y = np.meshgrid(np.linspace(0, length, columns), np.linspace(0, width, rows), indexing="ij")
    node = np.arange(columns * rows).reshape(columns, rows)
    a, b, c, d = (
        part.ravel() for part in (node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:])
    )
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    points = np.column_stack([x.ravel(), y.ravel()])
    return PlanarMesh(points, triangles, np.full(len(triangles), region))


def rolled(points, radius):
    """Bent along x to a circle of a radius, the substrate on the inner side."""
    angle = points[:, 0] / radius
    return np.column_stack([radius * np.sin(angle), points[:, 1], radius * np.cos(angle)])


def folded(points, gap, length=LENGTH):
    """Two flat flaps of a third of the length whose interfaces are `gap` apart, and a loop between.

    The loop bulges beyond the flaps, which are therefore what is nearest.
    """
    s = 3 * points[:, 0] / length - 1
    turn = math.pi * np.clip(s, 0, 1)
    straight = np.where(s < 0, s, np.where(s > 1, 1 - s, 0)) * length / 3
    loop = length / 15 * np.sin(turn)
    return np.column_stack([straight + 2 * loop, points[:, 1], (gap / 2 + loop) * np.cos(turn)])


def body(mesh, below=BELOW, above=ABOVE):
    everywhere = np.arange(len(mesh.triangles))
    kirigami = Sheet(0.0, above, mesh.faces_of("kirigami"))
    return BondedBody(mesh, [Sheet(-below, 0.0, everywhere), kirigami])


def stacked(mesh, levels, layers):
    """A body of layers between levels, each on all triangles or, as "kirigami", on some."""
    faces = {"whole": np.arange(len(mesh.triangles)), "kirigami": mesh.faces_of("kirigami")}
    faces["rest"] = np.setdiff1d(faces["whole"], faces["kirigami"])
    sheets = [
        Sheet(bottom, top, faces[name])
        for (bottom, top), name in zip(pairwise(levels), layers, strict=True)
    ]
    return BondedBody(mesh, sheets)


THREE = [-1.3e-3, -0.3e-3, 0.3e-3, 1.1e-3]
STACKS = {
    "bilayer": ([-BELOW, 0.0, ABOVE], ["whole", "kirigami"]),
    "bilayer, kirigami below": ([-ABOVE, 0.0, BELOW], ["kirigami", "whole"]),
    "single": ([-0.4e-3, 0.4e-3], ["whole"]),
    "trilayer": (THREE, ["kirigami", "whole", "kirigami"]),
    "trilayer of two patterns": (THREE, ["kirigami", "whole", "rest"]),
    "gaps between whole layers": (THREE, ["whole", "kirigami", "whole"]),
    "four": ([*THREE, 1.4e-3], ["whole", "kirigami", "kirigami", "kirigami"]),
}


def paper_disc(size=0.003):
    return generate_mesh(replace(paper_specimen(), mesh=MeshSize(size)))


@pytest.fixture(scope="module")
def disc():
    return paper_disc()


# the skin


@pytest.mark.parametrize("half_angle", [1e-9, 0.5, 1.2])
@pytest.mark.parametrize("stack", STACKS)
def test_the_skin_is_closed_and_holds_the_layers_volume(disc, half_angle, stack):
    made = stacked(disc, *STACKS[stack])
    skin = skin_of(made, Surface(cap(disc.points, half_angle), disc.triangles))
    triangles = skin.surface.triangles
    forth = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    edges, count = np.unique(forth, axis=0, return_counts=True)
    back = np.unique(forth[:, ::-1], axis=0)
    assert np.array_equal(edges, back)
    assert count.max() == 1 or "two patterns" in stack  # which meet in an edge
    volume = np.einsum("ij,ij", skin.surface.corners.mean(axis=1), skin.surface.area_vectors) / 3
    flat = sum((sheet.top - sheet.bottom) * disc.areas[sheet.faces].sum() for sheet in made.sheets)
    assert volume == pytest.approx(flat, rel=4e-3)


def test_a_layer_is_thinner_where_the_interface_is_stretched(disc):
    skin = skin_of(body(disc), Surface(1.1 * in_plane(disc.points), disc.triangles))
    heights = skin.surface.points[np.unique(skin.surface.triangles)][:, 2]
    assert heights.min() == pytest.approx(-BELOW / 1.21)
    assert heights.max() == pytest.approx(ABOVE / 1.21)


# touching, and how far from it


def test_flaps_touch_when_the_layers_between_them_fill_the_gap():
    mesh = strip()
    for gap in (0.1e-3, 0.5e-3):
        found = self_contact_gap(body(mesh), folded(mesh.points, 2 * BELOW + gap))
        assert found == pytest.approx(gap, rel=1e-6)
    assert self_contact_gap(body(mesh), folded(mesh.points, 2 * BELOW - 0.1e-3)) == 0


def test_flaps_of_a_trilayer_touch_by_its_outer_layers():
    mesh = strip()
    made = stacked(mesh, *STACKS["trilayer"])
    for mirror, outer in ((1, 1.3e-3), (-1, 1.1e-3)):
        position = folded(mesh.points, 2 * outer + 0.2e-3) * [1, 1, mirror]
        assert self_contact_gap(made, position) == pytest.approx(0.2e-3, rel=1e-6)
        position = folded(mesh.points, 2 * outer - 0.1e-3) * [1, 1, mirror]
        assert self_contact_gap(made, position) == 0


def test_flaps_folded_to_the_other_side_touch_by_their_kirigami():
    mirror = np.array([1, 1, -1])
    mesh, bare = strip(), strip(region=0)
    position = folded(mesh.points, 2 * ABOVE + 0.3e-3) * mirror
    assert self_contact_gap(body(mesh), position) == pytest.approx(0.3e-3, rel=1e-6)
    position = folded(mesh.points, 2 * ABOVE - 0.1e-3) * mirror
    assert self_contact_gap(body(mesh), position) == 0
    assert self_contact_gap(body(bare), position) == np.inf  # no kirigami, so a gap of 1.9 mm
    position = folded(bare.points, 0.3e-3) * mirror
    assert self_contact_gap(body(bare), position) == pytest.approx(0.3e-3, rel=1e-6)


@pytest.mark.parametrize("opening", [0.2e-3, 0.6e-3, 1.2e-3])
def test_a_sheet_rolled_into_a_tube_that_is_still_open(opening):
    """The inner edges of the rims come nearest: the opening over the radius, less a thickness."""
    mesh, radius = strip(width=0.003, size=0.00025), (LENGTH + opening) / (2 * math.pi)
    inner = BELOW / (1 - BELOW / 2 / radius)  # keeps its volume on the inner side
    expected = 2 * (radius - inner) * math.sin(opening / radius / 2)
    found = self_contact_gap(body(mesh), rolled(mesh.points, radius))
    assert found == pytest.approx(expected, abs=0.02e-3)


@pytest.mark.parametrize("overlap", [0.3e-3, 1e-3, 6e-3])
def test_a_sheet_rolled_into_a_tube_that_overlaps(overlap):
    mesh = strip()
    radius = (LENGTH - overlap) / (2 * math.pi)
    assert self_contact_gap(body(mesh), rolled(mesh.points, radius)) == 0


@pytest.mark.parametrize("size", [0.001, 0.005])
@pytest.mark.parametrize("thinner", [1, 0.05])
def test_flaps_that_cross_each_other_aslant(size, thinner):
    """Also where the triangles are much larger than the layers are thick."""
    mesh = strip(size=size)
    position = folded(mesh.points, 6e-3)
    far = mesh.points[:, 0] > 2 / 3 * LENGTH
    position[far, 2] += 0.7 * (mesh.points[far, 0] - 2 / 3 * LENGTH)
    assert self_contact_gap(body(mesh, thinner * BELOW, thinner * ABOVE), position) == 0


# no false alarm


def test_flat_dome_hemisphere_and_cylinder_are_free(disc):
    for position in (in_plane(disc.points), cap(disc.points, 0.8), cap(disc.points, math.pi / 2)):
        assert self_contact_gap(body(disc), position) == np.inf


@pytest.mark.parametrize("size", [0.003, 0.008])
def test_a_disc_that_shrank_as_the_substrate_would_is_free(size):
    mesh = paper_disc(size)
    position = in_plane(mesh.points) / 2.2
    assert self_contact_gap(replace(body(mesh), shrinkage=1 / 2), position) == np.inf


@pytest.mark.parametrize("over_thickness", [1.3, 1.6, 2.5])
def test_a_tight_curl_is_no_contact(over_thickness):
    """Three quarters of a circle whose inner side is short: neighbours come near, none touches."""
    radius = over_thickness * 2 * BELOW
    mesh = strip(length=1.5 * math.pi * radius, width=0.006, size=0.0003)
    assert self_contact_gap(body(mesh), rolled(mesh.points, radius)) > 0


@pytest.mark.parametrize("half_angle", [0.3, math.pi / 4])
@pytest.mark.parametrize("size", [0.001, 0.005])
def test_a_sharp_crease_is_no_contact(half_angle, size):
    """Neighbours at the crease of a bare sheet share nodes and are bent back, but do not touch."""
    mesh = strip(region=0, size=size)
    x = mesh.points[:, 0] - LENGTH / 2
    position = np.column_stack(
        [math.sin(half_angle) * x, mesh.points[:, 1], math.cos(half_angle) * np.abs(x)]
    )
    assert self_contact_gap(body(mesh), position) > 0.1e-3


# what must not matter


@pytest.mark.parametrize("gap", [0.3e-3, -0.2e-3])
def test_motion_and_numbering_do_not_matter(gap):
    mesh = strip(size=0.002)
    position = folded(mesh.points, 2 * BELOW + gap)
    expected = self_contact_gap(body(mesh), position)
    turn = Rotation.from_rotvec([0.4, -1.2, 0.9])
    moved = self_contact_gap(body(mesh), turn.apply(position) + 0.3)
    assert moved == pytest.approx(expected, abs=1e-12)
    random = np.random.default_rng(1)
    nodes, faces = random.permutation(len(mesh.points)), random.permutation(len(mesh.triangles))
    numbered = PlanarMesh(
        mesh.points[nodes], np.argsort(nodes)[mesh.triangles][faces], mesh.region[faces]
    )
    assert self_contact_gap(body(numbered), position[nodes]) == pytest.approx(expected, abs=1e-12)


def test_the_body_of_a_trilayer_is_as_thick_as_its_layers():
    sheet = trilayer().with_layer("upper", response=Response("fixed", (1.3, 1.1), angle=0.4))
    made = BondedBody.of(sheet, generate_mesh(sheet), (1.2, 1.2))
    assert made.thickness == pytest.approx(1.1e-3 / 1.44 + 1.6e-3 + 1.6e-3 / 1.43)
    assert made.shrinkage == pytest.approx(1 / 1.3)
    lower, middle, upper = made.sheets
    assert (lower.top, middle.top) == (middle.bottom, upper.bottom)
    assert middle.top == -middle.bottom


def test_the_body_of_a_specimen():
    specimen, mesh = paper_specimen(), strip()
    made = BondedBody.of(specimen, mesh, (1.25, 1.2))
    (below, bond), (other, above) = ((sheet.bottom, sheet.top) for sheet in made.sheets)
    assert bond == other == 0
    assert below == pytest.approx(-specimen.layer("substrate").thickness / 1.5)
    assert above == specimen.layer("kirigami").thickness
    assert made.shrinkage == pytest.approx(1 / 1.25)


def test_twenty_thousand_triangles_take_seconds_at_most():
    mesh = strip(length=0.1, width=0.1, size=0.001)
    start = time.process_time()
    found = self_contact_gap(body(mesh), folded(mesh.points, 2 * BELOW + 0.2e-3, length=0.1))
    assert len(mesh.triangles) == 20_000
    assert found == pytest.approx(0.2e-3, rel=1e-6)
    assert time.process_time() - start < 20


# in the result


def curled_result(milestones=(1.03, 1.06, 1.09)):
    """The disc rolled to a tube: half open, nearly closed, and through itself."""
    specimen = small_specimen(milestones)
    mesh = generate_mesh(replace(specimen, mesh=MeshSize(0.004)))
    radii = iter((0.03, 0.0132, 0.009))
    return cap_result(
        specimen, mesh=mesh, motion=lambda _: rolled(mesh.points + np.array([0.04, 0]), next(radii))
    )


def test_every_result_carries_the_gap_and_says_where_it_touches():
    result = curled_result()
    gaps = result["self_contact_gap"].values
    assert gaps[0] == np.inf
    assert gaps[2] == 0
    assert gap_words(result)[2] == "touches"
    assert "itself" in result_table(result).splitlines()[1]
    assert "TOUCHES ITSELF" in describe_trust(result)
    assert "1.09" in describe_trust(result).split("TOUCHES ITSELF")[1]


def test_free_missing_and_older_results_say_so():
    stopped = cap_result(reached=1.065)
    assert gap_words(stopped) == ["wide", "wide", "-"]
    assert "does not touch itself" in describe_trust(stopped)
    older = stopped.drop_vars("self_contact_gap")
    assert gap_words(older) == ["?", "?", "?"]
    assert "not looked for" in describe_trust(older)
