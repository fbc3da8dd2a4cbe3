"""The table of known states: it is that of the numbers, and is put between its marks."""

from pathlib import Path

import known_states
import numpy as np
import xarray as xr
from sheet_comparison.table import read_table

ROOT = Path(__file__).parents[2]


def test_the_page_has_the_table_of_the_numbers():
    rows = read_table(ROOT / "results" / "known_states.csv", known_states.Row)
    text = (ROOT / "docs" / "states.md").read_text()
    assert known_states.page_with(text, rows) == text
    assert known_states.table(rows[:1]) not in known_states.page_with(text, rows[1:])
    searched = {(row.strips, row.prestretch) for row in rows if row.mesh == 0.006}
    assert searched == set(known_states.SHEETS)


def test_a_row_is_a_state_of_the_search():
    along = "prestretch"
    found = xr.Dataset(
        {
            "energy": ((along, "term"), [[1.0, 2.0], [3.0, 1.0]]),
            "quality": (along, [0.2, 0.3]),
            "height": (along, [0.02, 0.03]),
            "times_found": (along, [4, 1]),
            "self_contact_gap": (along, [np.inf, 0.0]),
            "start_state": ("start", [0, 0, 1]),
            "start_name": ("start", ["path", "random 1", "random 2"]),
        }
    )
    first, second = known_states.rows_of(6, 1.15, 0.006, found)
    assert (first.energy, first.starts, first.random, first.found) == (3.0, 3, 2, 4)
    assert (second.energy, second.gap) == (4.0, 0.0)
    assert "4000000.00 (touches)" in known_states.table([second])
