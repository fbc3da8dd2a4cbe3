"""The study of the published bistable sheets: cases, threshold, verdicts, the page that is kept."""

import math
from dataclasses import replace
from pathlib import Path

import bistable_sheets
import pytest
import xarray as xr
from bistable.cases import CROSS, LOTUS, Case, trilayer
from bistable.page import page
from bistable.rows import Point, Row, bent_from, mirror_pairs, top_of
from sheet_comparison.table import read_table

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("sheet", [LOTUS, CROSS])
def test_a_trilayer_is_itself_turned_over(sheet):
    lower, substrate, upper = trilayer(sheet, 0.5).layers
    assert lower.thickness == upper.thickness == pytest.approx(0.8e-3)
    assert (lower.pattern, lower.material) == (upper.pattern, upper.material)
    assert substrate.thickness == pytest.approx(1.1e-3)
    assert Case(sheet, 0.5, 1.2).specimen.milestones == ((1.2, 1.2),)


def test_the_threshold_of_a_square_root_is_found():
    path = [
        Point(LOTUS, 1e-3, stretch, 0.02 * math.sqrt(max(stretch - 1.0732, 0.0)))
        for stretch in (1.3, 1.2, 1.1, 1.08, 1.07, 1.06)
    ]
    assert bent_from(path) == pytest.approx(1.0732, abs=1e-9)
    assert math.isnan(bent_from([replace(point, height=0.0) for point in path]))


def test_pairs_and_the_highest_shape_are_read_from_the_files():
    states = xr.Dataset({"turned_over": ("prestretch", [2, -1, 0, 4, 3])})
    assert mirror_pairs(states) == [(0, 2), (3, 4)]
    energy = (("prestretch", "term"), [[9.0], [1.0], [3.0], [2.0], [8.0]])
    assert top_of(xr.Dataset({"energy": energy}))["energy"].item() == 3.0


def test_the_page_is_that_of_the_numbers_and_the_names_are_checked(capsys):
    rows = read_table(ROOT / "results" / "bistable_sheets.csv", Row)
    points = read_table(ROOT / "results" / "bistable_paths.csv", Point)
    assert page(rows, points) == (ROOT / "docs" / "bistable_sheets.md").read_text()
    pair = next(row for row in rows if row.pairs == 1)
    assert pair.mirror < 1e-9
    assert replace(pair, states=3).verdict == "3 states"
    assert replace(pair, pairs=0, states=1, height=0.0).verdict == "flat alone"
    assert bistable_sheets.main(["lotus_9_1.2"]) == 2
    assert "CASE = 'lotus_9_1.2'" in capsys.readouterr().err
