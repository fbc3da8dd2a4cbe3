"""Fields of density: shares at places, mirrors, projection, and the pattern that is cut out."""

import numpy as np
import pytest
import shapely

import bilayer
from bilayer import DensityField, Disc, InputError, Rectangle
from bilayer.specimen.pattern import kept_share

SHEET = Rectangle(0.04, 0.04)
RNG = np.random.default_rng(4)


def square_field(mirrors, count, **options):
    numbers = {"none": count**2, "axes": count**2, "diagonals": count * (count + 1) // 2}
    shares = tuple(RNG.uniform(size=numbers[mirrors]))
    return DensityField(0.04, 0.04, count, count, shares, mirrors, **options)


def test_shares_go_linearly_between_the_nodes():
    field = DensityField(0.04, 0.02, 3, 2, (0.0, 0.5, 1.0, 0.2, 0.4, 0.9))
    corners = np.array([[-0.02, -0.01], [0.0, -0.01], [0.02, 0.01], [0.01, -0.01], [0.0, 0.0]])
    assert field.share_at(corners) == pytest.approx([0.0, 0.5, 0.9, 0.75, 0.45])


@pytest.mark.parametrize("mirrors", ["axes", "diagonals"])
def test_mirrors_leave_a_field_as_it_is(mirrors):
    field, points = square_field(mirrors, 4), RNG.uniform(-0.02, 0.02, (50, 2))
    shares = field.share_at(points)
    assert field.share_at(points * [-1, 1]) == pytest.approx(shares)
    assert field.share_at(points * [1, -1]) == pytest.approx(shares)
    swapped = field.share_at(points[:, ::-1])
    assert np.allclose(swapped, shares) == (mirrors == "diagonals")


def test_a_sharp_field_is_nearly_none_or_all():
    points = RNG.uniform(-0.02, 0.02, (400, 2))
    soft = square_field("none", 5)
    values = np.array(soft.share)
    sharp = DensityField(0.04, 0.04, 5, 5, tuple(values), sharpness=60.0).share_at(points)
    plain = soft.share_at(points)
    assert ((sharp > 0.5) == (plain > 0.5)).all()
    far = np.abs(plain - 0.5) > 0.1
    assert np.minimum(sharp, 1 - sharp)[far].max() < 0.01


def test_the_ends_of_a_projection_stay():
    field = DensityField(0.04, 0.04, 2, 2, (0.0, 1.0, 0.0, 1.0), sharpness=7.0)
    ends = field.share_at(np.array([[-0.02, 0.0], [0.02, 0.0], [0.0, 0.0]]))
    assert ends == pytest.approx([0.0, 1.0, 0.5])


def test_what_is_cut_out_is_where_the_share_is_less_than_a_half():
    field = square_field("axes", 5, sharpness=8.0)
    pattern = field.cut_pattern(SHEET)
    points = RNG.uniform(-0.0199, 0.0199, (2000, 2))
    inside = shapely.contains_xy(pattern.kept(SHEET), *points.T)
    assert np.mean(inside != (field.share_at(points) >= 0.5)) < 0.01
    assert kept_share(field, SHEET) == 1.0


def test_a_strip_is_cut_out_with_its_area():
    field = DensityField(0.04, 0.04, 3, 2, (1.0, 0.0, 0.0, 1.0, 0.0, 0.0), "axes")
    assert field.cut_pattern(SHEET).kept(SHEET).area == pytest.approx(0.01 * 0.04, rel=1e-6)
    with pytest.raises(InputError, match="below a half everywhere"):
        DensityField(0.04, 0.04, 2, 2, (0.1,) * 4).cut_pattern(SHEET)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"share": (0.5,) * 3}, "has 3 values, expected 4"),
        ({"share": (0.5, 0.5, 0.5, 1.5)}, "expected 0 to 1"),
        ({"mirrors": "diagonals", "share": (0.5,) * 3, "height": 0.03}, "diagonals"),
        ({"mirrors": "turns"}, "mirrors"),
        ({"columns": 1}, "columns"),
        ({"sharpness": -1.0}, "sharpness"),
    ],
)
def test_what_is_no_field_is_refused(changes, says):
    good = {"width": 0.04, "height": 0.04, "columns": 2, "rows": 2, "share": (0.5,) * 4}
    with pytest.raises(InputError, match=says):
        DensityField(**(good | changes))


def test_a_grid_lies_over_all_of_the_sheet():
    with pytest.raises(InputError, match=r"width = 0\.04 m: expected at least 0\.06 m"):
        square_field("none", 3).check_fit(Disc(0.03))


def test_a_field_is_a_kind_of_pattern_in_a_specimen_file(tmp_path):
    specimen = bilayer.paper_specimen()
    field = DensityField(0.08, 0.08, 3, 3, tuple(RNG.uniform(size=9)), sharpness=2.0)
    specimen = specimen.with_layer("kirigami", pattern=field)
    (tmp_path / "s.toml").write_text(bilayer.specimen_to_toml(specimen))
    assert bilayer.read_specimen(tmp_path / "s.toml").layer("kirigami").pattern == field
