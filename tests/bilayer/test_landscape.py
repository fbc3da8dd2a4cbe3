"""Symmetry of specimens, images of shapes, starts, and the catalogue of states."""

import math
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest
from grids import grid_mesh, rectangle

import bilayer
from bilayer import Polygons
from bilayer.landscape.catalogue import Catalogue, State, chance_of_another
from bilayer.landscape.schedule import schedule
from bilayer.landscape.starts import Sheet, rolling_axes
from bilayer.landscape.symmetry import Images, interpolation, symmetry_of
from bilayer.results.schema import MilestoneState
from bilayer.specimen.outline import Symmetry

GRID = grid_mesh(rectangle(8, 8), size=0.01, origin=(-0.04, -0.04))
LENGTH = 0.04
SQUARE = Symmetry(4, True)
EQUAL = (1.1, 1.1)


def drawn(*corners):
    """The paper's specimen with a polygon cut out of its upper layer, corners in mm."""
    cut = Polygons((tuple((x / 1e3, y / 1e3) for x, y in corners),), what="cut")
    return bilayer.paper_specimen().with_layer("kirigami", pattern=cut)


def bent(points, x=0.0, y=0.0):
    """A graph over the plane with curvatures along x and y, 1/m."""
    return np.column_stack([points, (x * points[:, 0] ** 2 + y * points[:, 1] ** 2) / 2])


@pytest.mark.parametrize(
    ("corners", "expected"),
    [
        ([(10, 10), (-10, 10), (-10, -10), (10, -10)], SQUARE),
        ([(20, 10), (-20, 10), (-20, -10), (20, -10)], Symmetry(2, True)),
        ([(20, 5), (-10, 10), (-20, -5), (10, -10)], Symmetry(2, False)),
        ([(20, 5), (-10, 10), (-20, -5)], Symmetry(1, False)),
    ],
)
def test_the_symmetry_of_a_drawn_cut_is_found(corners, expected):
    assert symmetry_of(drawn(*corners), EQUAL) == expected


def test_a_prestretch_along_two_axes_leaves_half_a_turn():
    square = drawn((10, 10), (-10, 10), (-10, -10), (10, -10))
    assert symmetry_of(square, (1.1, 1.05)) == Symmetry(2, True)


def test_a_linear_function_is_taken_to_any_place():
    places = np.random.default_rng(0).uniform(-0.045, 0.045, (40, 2))  # some beyond the mesh
    values = GRID.points @ [2.0, -3.0] + 1
    assert interpolation(GRID, places) @ values == pytest.approx(places @ [2.0, -3.0] + 1)


def test_images_under_the_symmetry_are_one_shape_and_others_are_not():
    images = Images(GRID, SQUARE)
    along_x, along_y = bent(GRID.points, x=20.0), bent(GRID.points, y=20.0)
    assert images.distance(along_x, along_y) < 1e-9
    assert images.plain_distance(along_x, along_y) > 1e-3
    turned_over = along_x * [1, 1, -1]
    assert images.distance(along_x, turned_over) > 1e-3
    assert images.symmetry_of(along_x, 1e-6) == Symmetry(2, True)
    assert images.symmetry_of(bent(GRID.points, 20.0, 20.0), 1e-6) == SQUARE
    chiral = bent(GRID.points)
    chiral[:, 2] = 20.0 * GRID.points[:, 0] * GRID.points[:, 1] + 30 * GRID.points[:, 0] ** 2
    assert images.symmetry_of(chiral, 1e-6) == Symmetry(2, False)


def test_a_sheet_that_any_turn_leaves_has_one_rolled_shape():
    disc = bilayer.generate_mesh(replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.006)))
    sheet = Sheet(disc, LENGTH)
    images = Images(disc, Symmetry(0, True))
    apart = images.distance(sheet.rolled(0.2, 1.5), sheet.rolled(1.2345, 1.5))
    assert apart < 0.002 * LENGTH


def test_starts_are_isometric_where_they_can_be():
    sheet = Sheet(GRID, LENGTH)
    edges = GRID.edges
    flat = np.linalg.norm(np.diff(GRID.points[edges], axis=1), axis=(1, 2))
    rolled = sheet.rolled(0.3, 0.5)
    lengths = np.linalg.norm(np.diff(rolled[edges], axis=1), axis=(1, 2))
    assert lengths == pytest.approx(flat, rel=2e-3)
    dome = sheet.dome(1.2)
    apex = dome[np.argmin(np.hypot(*GRID.points.T))]
    radius = LENGTH / 1.2
    centre = np.add(apex, [0, 0, radius])
    assert np.linalg.norm(dome - centre, axis=1) == pytest.approx(radius, rel=1e-9)


def test_axes_of_rolling_are_none_of_each_others_images():
    five = rolling_axes(Symmetry(5, True))
    assert five == pytest.approx([0, math.pi / 20, math.pi / 10])
    assert len(rolling_axes(Symmetry(1, False))) == 5


def state_of(position, energy):
    milestone = MilestoneState(position, True, 1.1, {"sheet": energy})
    return State(milestone, np.array([1.0, 2.0]), Symmetry(1, False))


def test_a_catalogue_tells_new_states_from_known_ones():
    catalogue = Catalogue(Images(GRID, SQUARE), LENGTH)
    along_x, along_y = bent(GRID.points, x=20.0), bent(GRID.points, y=20.0)
    place = catalogue.add(state_of(along_x, 1e-3))
    assert catalogue.place_of(along_y, 1.0001e-3) == place
    assert catalogue.place_of(along_y, 1.1e-3) is None  # of another energy
    assert catalogue.place_of(bent(GRID.points, 20.0, 20.0), 1e-3) is None
    catalogue.add(state_of(bent(GRID.points, 20.0, 20.0), 0.9e-3))
    catalogue.count_again(place)
    assert [catalogue.states[k].times_found for k in catalogue.order()] == [1, 2]
    assert len(list(catalogue.shapes_to_avoid())) == 3  # along x, along y, the dome
    assert not catalogue.is_lower(place, 1.0001e-3) and catalogue.is_lower(place, 0.9999e-3)
    catalogue.keep_image(place, state_of(along_y, 0.9999e-3))
    assert (catalogue.states[place].energy, catalogue.states[place].times_found) == (0.9999e-3, 2)


def test_a_schedule_names_its_starts_once_and_follows_what_is_found():
    catalogue = Catalogue(Images(GRID, SQUARE), LENGTH)
    starts = schedule(Sheet(GRID, LENGTH), catalogue, lambda steps: bent(GRID.points))
    names = [start.name for start in islice(starts, 35)]
    catalogue.add(state_of(bent(GRID.points, x=20.0), 1e-3))
    later = [next(starts) for _ in range(3)]
    assert [start.name for start in later][:2] == ["state 0 turned over", "away from state 0"]
    assert [start.avoids_known for start in later] == [False, True, False]
    names += [start.name for start in later]
    assert len(set(names)) == len(names)
    shapes = [start.make_shape() for start in later]
    assert all(shape.shape == (len(GRID.points), 3) for shape in shapes)
    assert shapes[0][:, 2] == pytest.approx(-bent(GRID.points, x=20.0)[:, 2])


def test_random_starts_are_the_same_each_time_and_of_the_sheets_size():
    sheet = Sheet(GRID, LENGTH)
    for seed in range(4):
        shape = sheet.random(seed)
        assert np.array_equal(shape, sheet.random(seed))
        assert 0.05 * LENGTH < np.ptp(shape[:, 2]) < 4 * LENGTH
    assert not np.allclose(sheet.random(1), sheet.random(3))


def test_the_chance_of_another_state_is_the_share_of_those_found_once():
    assert chance_of_another(np.array([5, 1, 1]), 10) == 0.2
