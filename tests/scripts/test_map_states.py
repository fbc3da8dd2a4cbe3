"""The script of the default results on the maps: the page is that of its numbers."""

from dataclasses import replace
from pathlib import Path

import map_states
from fe_maps import MapCase, map_cases
from sheet_comparison.table import read_table

import bilayer

ROOT = Path(__file__).parents[2]


def test_the_page_is_that_of_the_numbers_and_has_every_specimen():
    rows = read_table(ROOT / "results" / "map_states.csv", map_states.Row)
    assert map_states.page(rows) == (ROOT / "docs" / "map_states.md").read_text()
    judged = [map_states.PATH[place] for place in map_states.JUDGED]
    assert [(row.case, row.prestretch) for row in rows] == [
        (case.name, stretch) for case in map_cases() for stretch in judged
    ]
    assert all(row.lowest <= row.energy * (1 + 1e-12) for row in rows)


def test_a_state_that_is_lower_is_named():
    row = map_states.Row("a sheet", 1.06, 12, 2, 2.0, 1.5)
    assert row.lower_state == -0.25
    assert replace(row, lowest=2.0 * (1 - 1e-9)).lower_state == 0.0
    assert "1 of 2 default results" in map_states.page([row, replace(row, lowest=2.0)])


def test_rows_are_the_default_result_and_the_search_from_it(monkeypatch):
    monkeypatch.setattr(map_states, "PATH", (1.01, 1.02))
    monkeypatch.setattr(map_states, "JUDGED", (1,))
    sheet = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.016))
    (row,) = map_states.rows_of(MapCase("coarse", sheet), 1)
    alone = bilayer.solve(sheet.with_milestones([1.01, 1.02]), "dshell")
    expected = float(alone["energy"].sum("term").values[1])
    assert abs(row.energy / expected - 1) < 1e-6
    assert (row.case, row.prestretch, row.starts, row.lower_state) == ("coarse", 1.02, 1, 0.0)
