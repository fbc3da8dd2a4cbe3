"""Outlines: closed-form areas, the polygon that stands for them, symmetries, checks."""

import math
from dataclasses import replace

import numpy as np
import pytest
import shapely
from sheets import OUTLINES, circle, square

from bilayer import Disc, Ellipse, InputError, Polygon, Rectangle, RegularPolygon
from bilayer.specimen.outline import Symmetry

AREAS = {
    "disc": math.pi * 0.02**2,
    "ellipse": math.pi * 0.03 * 0.02,
    "rectangle": 0.05 * 0.04,
    "rounded": 0.05 * 0.04 - (4 - math.pi) * 0.008**2,
    "stadium": 0.03 * 0.03 + math.pi * 0.015**2,
    "hexagon": 3 * math.sqrt(3) / 2 * 0.022**2,
    "holes": 0.04**2 - 0.008**2 - 30 * 0.003**2 * math.sin(2 * math.pi / 60),
    "L": 3 * 0.02**2,
}


@pytest.mark.parametrize("name", OUTLINES)
def test_areas_are_those_of_the_closed_form_and_of_the_polygon(name):
    outline = OUTLINES[name]
    assert outline.area == pytest.approx(AREAS[name], rel=1e-12)
    assert outline.polygon.area == pytest.approx(AREAS[name], rel=2e-5)
    assert outline.polygon.is_valid
    assert math.pi * outline.characteristic_length**2 == pytest.approx(AREAS[name], rel=1e-12)


def test_the_characteristic_length_of_a_disc_is_its_radius():
    assert Disc(0.0393).characteristic_length == 0.0393  # to the last bit


@pytest.mark.parametrize("name", OUTLINES)
def test_the_centroid_is_that_of_the_polygon(name):
    outline = OUTLINES[name]
    expected = outline.polygon.centroid
    assert outline.centroid == pytest.approx((expected.x, expected.y), abs=1e-9)


@pytest.mark.parametrize("outline", [*OUTLINES.values(), RegularPolygon(5, 0.02, 0.1),
                                     RegularPolygon(4, 0.02, math.pi / 4)], ids=str)  # fmt: skip
def test_symmetries_leave_it_as_it_is(outline):
    polygon, (turns, mirrored) = outline.polygon, outline.symmetry
    angle = 0.7 if turns == 0 else 2 * math.pi / turns
    same = [shapely.affinity.rotate(polygon, angle, origin=(0, 0), use_radians=True)]
    if mirrored:
        same.append(shapely.affinity.scale(polygon, 1, -1, origin=(0, 0)))
    for moved in same:
        assert polygon.symmetric_difference(moved).area < 1e-4 * polygon.area


def test_a_turned_polygon_has_no_mirror_at_the_x_axis():
    assert RegularPolygon(5, 0.02, 0.1).symmetry == Symmetry(5, False)
    assert Rectangle(0.04, 0.04).symmetry == Symmetry(4, True)


def test_common_symmetries():
    assert Symmetry(0, True).common(Symmetry(5, True)) == Symmetry(5, True)
    assert Symmetry(4, True).common(Symmetry(10, False)) == Symmetry(2, False)


def test_equal_outlines_have_one_identity_and_others_have_others():
    texts = {outline.identity for outline in OUTLINES.values()}
    assert len(texts) == len(OUTLINES)
    for outline in OUTLINES.values():
        assert replace(outline).identity == outline.identity


def test_numbers_of_numpy_are_kept_as_plain_ones():
    outline = RegularPolygon(np.int64(6), np.float32(0.5))
    assert (type(outline.sides), type(outline.outer_radius)) == (int, float)
    points = Polygon(np.array(square(0, 0, 1.0))).points
    assert {type(value) for point in points for value in point} == {float}
    assert RegularPolygon(6.0, 0.02) == RegularPolygon(6, 0.02)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Disc(0), "outer_radius = 0 m: expected a number greater than 0"),
        (lambda: Ellipse(0.04, -1), "height = -1 m: expected"),
        (lambda: Rectangle(0.04, 0.03, 0.016), r"corner_radius = 0.016 m: .* shorter side, 0.015"),
        (lambda: RegularPolygon(2, 0.04), "sides = 2: expected a whole number of at least 3"),
        (lambda: Polygon(((0, 0), (1, 0))), "points: has 2 corners, expected at least 3"),
        (lambda: Polygon(((0, 0), (1, 0), (1, 1, 1))), r"points\[2\] = .*: expected a pair"),
        (lambda: Polygon(((0, 0), (1, 0), (1, "a"))), r"points\[2\] = 'a': expected a number"),
        (lambda: Polygon(((0, 0), (1, 1), (1, 0), (0, 1))), "points: .* does not cross itself"),
        (lambda: Polygon("square"), "points = 'square': expected a list"),
        (lambda: Polygon(square(0, 0, 1), (circle(1, 0, 0.5),)), "points: make no polygon in one"),
        (lambda: Polygon(square(0, 0, 1), (square(3, 0, 1),)), "points: make no polygon in one"),
    ],
)
def test_bad_outlines_are_named(make, message):
    with pytest.raises(InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("outline", "field"),
    [
        (lambda: Rectangle(1e30, 0.04, 0.001), "width"),
        (lambda: RegularPolygon(5, 0.02, 1e30), "angle"),
        (lambda: RegularPolygon(10**9, 0.02), "sides"),
    ],
)
def test_numbers_whose_corners_fall_together_are_refused(outline, field):
    with pytest.raises(InputError, match=field):
        outline()
