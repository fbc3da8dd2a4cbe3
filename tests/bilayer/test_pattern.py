"""Patterns: where a layer lies on an outline, in closed form; symmetries, checks."""

import math

import numpy as np
import pytest
import shapely
from sheets import OUTLINES, PATTERNS, circle, square

from bilayer import Cross, CutPattern, Disc, InputError, Polygons, Rectangle, SectorProfile
from bilayer.specimen.pattern import kept_share

DISC, SQUARE = Disc(0.02), Rectangle(0.04, 0.04)


def test_sectors_keep_what_is_between_them():
    share = kept_share(CutPattern(5, 0.008, 0.3), DISC)
    expected = 1 - 5 * 0.3 / (2 * math.pi) * (1 - (0.008 / 0.02) ** 2)
    assert share == pytest.approx(expected, rel=1e-5)
    assert kept_share(None, DISC) == 1.0


def test_a_constant_profile_is_sectors():
    """Its cutouts are those of `CutPattern`, between its radii and beyond them."""
    profile = SectorProfile(5, (0.008, 0.015), (0.15, 0.15))
    for outline in OUTLINES.values():
        kept = profile.kept(outline)
        apart = kept.symmetric_difference(CutPattern(5, 0.008, 0.3).kept(outline)).area
        assert apart < 2e-5 * outline.area


def test_the_area_of_a_profile_is_the_integral_of_its_half_angle():
    profile = SectorProfile(6, (0.005, 0.01, 0.02), (0.0, 0.2, 0.1))
    r = np.linspace(0.005, 0.02, 20_001)
    cut = 6 * np.trapezoid(2 * profile.half_angle(r) * r, r)
    assert profile.kept(DISC).area == pytest.approx(DISC.area - cut, rel=2e-5)


def test_a_profile_goes_through_its_values_without_an_extremum_between():
    profile = SectorProfile(6, (0.005, 0.01, 0.02), (0.0, 0.2, 0.1))
    assert profile.half_angle(np.array(profile.radii)) == pytest.approx(profile.half_angles)
    first, second = (
        profile.half_angle(np.linspace(*ends)) for ends in ((0.005, 0.01), (0.01, 0.02))
    )
    assert (np.diff(first) >= 0).all()
    assert (np.diff(second) <= 0).all()
    assert profile.half_angle(np.array([0.03])) == pytest.approx(0.1)


def test_polygons_are_kept_or_cut():
    shapes = (square(0, 0, 0.006), circle(0.005, 0, 0.004))  # they overlap
    kept = Polygons(shapes).kept(SQUARE)
    cut = Polygons(shapes, "cut").kept(SQUARE)
    assert kept.area + cut.area == pytest.approx(SQUARE.area)
    union = shapely.union_all([shapely.Polygon(points) for points in shapes])
    assert kept.area == pytest.approx(union.area)


def test_a_cross_is_two_bars():
    width = 0.0033
    assert Cross(width).kept(SQUARE).area == pytest.approx(2 * width * 0.04 - width**2)
    assert Cross(width, 0.03).kept(SQUARE).area == pytest.approx(2 * width * 0.03 - width**2)
    assert Cross(width, 0.03, 0.5).kept(SQUARE).area == pytest.approx(2 * width * 0.03 - width**2)


SYMMETRIC = [*filter(None, PATTERNS.values()), Cross(0.004, None, math.pi / 4)]


@pytest.mark.parametrize("pattern", SYMMETRIC, ids=str)
def test_symmetries_leave_it_as_it_is(pattern):
    kept, (turns, mirrored) = pattern.kept(DISC), pattern.symmetry
    same = [shapely.affinity.rotate(kept, 2 * math.pi / turns, origin=(0, 0), use_radians=True)]
    if mirrored:
        same.append(shapely.affinity.scale(kept, 1, -1, origin=(0, 0)))
    for moved in same:
        assert kept.symmetric_difference(moved).area < 1e-4 * kept.area


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: CutPattern(0, 0.008, 0.3), "strips = 0: leave the pattern out"),
        (lambda: CutPattern(5, 0.008, 1.3), r"cutout_angle = 1.3 rad: 5 cutouts need less"),
        (lambda: SectorProfile(5, (0.008,), (0.1,)), "radii = .*: expected at least two"),
        (lambda: SectorProfile(5, (0.01, 0.008), (0.1, 0.1)), "expected at least two, ascending"),
        (lambda: SectorProfile(5, (0.008, 0.01), (0.1,)), "half_angles: has 1 values"),
        (lambda: SectorProfile(5, (0.008, 0.01), (0.1, 0.7)), r"half_angles = .* below pi/5"),
        (lambda: SectorProfile(5, (0.008, 0.01), (0, 0)), "half_angles = .* above 0"),
        (lambda: Polygons(()), r"polygons = \[\]: expected at least one"),
        (lambda: Polygons((square(0, 0, 1),), "keep"), "what = 'keep': .*did you mean 'kept'"),
        (lambda: Cross(0.004, 0.003), "arm_length = 0.003 m: expected more than arm_width"),
        (lambda: CutPattern(5, 0.03, 0.3).check_fit(DISC), "inner_radius = 0.03 m: .*outer_radius"),
        (lambda: CutPattern(5, 0.03, 0.3).check_fit(SQUARE), "kept = all of the outline"),
        (lambda: Polygons((square(1, 0, 0.1),)).check_fit(DISC), "kept = none of the outline"),
    ],
)
def test_bad_patterns_are_named(make, message):
    with pytest.raises(InputError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
