"""Targets by formula against their areas, from files against what was written."""

import math
from pathlib import Path

import numpy as np
import pytest

from bilayer import InputError, paper_specimen
from bilayer.designing.targets import (
    cap,
    cylinder,
    ellipsoid,
    height_map,
    read_target,
    saddle,
    target_from_table,
)


@pytest.mark.parametrize(
    ("surface", "area"),
    [
        (cap(0.02), 2 * math.pi * 0.02**2),
        (cap(0.02, math.pi / 3), math.pi * 0.02**2),
        (ellipsoid(0.02, 0.02, 0.02), 2 * math.pi * 0.02**2),
        (cylinder(0.03, 0.04), math.pi * 0.04**2),
        (saddle(0.04, 1e-6), math.pi * 0.04**2),
    ],
)
def test_areas_of_formulas(surface, area):
    assert surface.areas.sum() == pytest.approx(area, rel=0.01)
    assert surface.area_vectors[:, 2].sum() > 0


def test_points_lie_on_the_formula():
    assert np.allclose(np.linalg.norm(cap(0.02).points, axis=1), 0.02)
    x, y, z = saddle(0.04, 10.0).points.T
    assert np.allclose(z, 5 * (x**2 - y**2))
    x, _, z = cylinder(0.03, 0.04).points.T
    assert np.allclose(np.hypot(x, z), 0.03)


def test_a_hemisphere_without_a_radius_has_the_meridian_of_the_sheet():
    target = target_from_table({"shape": "hemisphere"}, Path(), paper_specimen())
    assert target.surface.points[:, 2].max() == pytest.approx(0.08 / math.pi, rel=1e-3)
    assert not target.is_size_free


def test_a_map_of_heights_leaves_its_holes_open():
    x, y = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 21))
    points = np.column_stack([x.ravel(), y.ravel(), (x * y).ravel()])
    kept = np.hypot(x, y).ravel() > 0.35
    whole, holed = height_map(points), height_map(points[kept])
    assert (1 - holed.areas.sum() / whole.areas.sum()) * 4 > 0.2
    assert (holed.area_vectors[:, 2] > 0).all()


def test_a_table_is_read_in_its_unit(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("# a note\nx_mm,y_mm,z_mm\n0,0,1\n10,0,1\n0,10,1\n10,10,3\n")
    assert read_target(file).points.max() == pytest.approx(0.01)
    assert read_target(file, "m").points.max() == 10


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"shape": "dome"}, "shape = 'dome'"),
        ({"shape": "hemisphere", "depth": 0.1}, "depth"),
        ({"shape": "ellipsoid", "width": 0.1}, "missing"),
        ({"shape": "hemisphere", "size": "large"}, "target.size = 'large'"),
        ({"file": "none.csv"}, "none.csv"),
        ({"file": "none.txt.gz"}, "expected a name in"),
        ({"file": "a.csv", "radius": 1.0}, "target.radius"),
    ],
)
def test_what_is_no_target_is_named(table, words, tmp_path):
    with pytest.raises(InputError, match=words):
        target_from_table(table, tmp_path, paper_specimen())


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("t.csv", "0,0,0\n1,0,0\n2,0,0\n3,0,0\n", "on a line"),
        ("t.csv", "1,1,1\n" * 9, "in one place"),
        ("t.csv", "0,0,0\n1e300,0,0\n0,1e300,0\n1e300,1e300,1\n", "beyond all lengths"),
        ("t.obj", "v 0 0 0\nf 1 2 3\n", "a triangle has the point"),
        ("t.obj", "v 0 0 0\nv nan 0 0\nv 0 9 0\nf 1 2 3\n", "no numbers"),
        ("t.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n", "in one point"),
    ],
)
def test_files_without_a_surface_are_bad_input(tmp_path, name, content, words):
    (tmp_path / name).write_text(content)
    with pytest.raises(InputError, match=words):
        read_target(tmp_path / name)
