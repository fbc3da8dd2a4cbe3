"""The script of the finite-element maps: its cases, and the page that it writes."""

import fe_maps
import pytest

from bilayer import read_specimen, solve


def test_each_specimen_of_the_maps_is_one_case():
    cases = fe_maps.map_cases()
    names = [case.name for case in cases]
    assert len(names) == len(set(names)) == 6 + 10 + 7  # the template itself is in all three
    assert {"strips = 3", "cutout_angle = 1.1", "inner_radius = 0.032"} <= set(names)
    for case in cases:
        assert case.specimen.mesh.size == 0.006
        assert len(case.specimen.prestretch.milestones) == 8
    assert len({case.file(fe_maps.RESULTS) for case in cases}) == len(cases)


def test_the_cases_beside_the_maps_are_what_they_are_called():
    disc, middle, far = fe_maps.other_cases()
    assert disc.specimen.characteristic_length == 0.05
    assert (middle.specimen.prestretch.nominal, far.specimen.prestretch.nominal) == ([1.34], [1.78])


def test_the_page_has_what_each_case_took(tmp_path):
    pytest.importorskip("dolfinx")
    sheet = read_specimen(
        fe_maps.STUDIES / "specimen.toml", ["mesh.size=0.016", "prestretch.milestones=[1.02]"]
    )
    case = fe_maps.MapCase("one sheet", sheet)
    result = fe_maps.solve_case(case, tmp_path)
    again = fe_maps.solve_case(case, tmp_path)
    assert again["cpu_time"].values == pytest.approx(
        result["cpu_time"].values
    )  # not computed again
    table = fe_maps.cost_table([case], tmp_path)
    text = fe_maps.page(table, table)
    row = f"| one sheet | 1 of 1 | 0 | {int(result['iterations'].sum())} | "
    assert text.count(row) == 2
    assert "- not reached: 0 points (asked: 0)" in text
    assert fe_maps.NOT_COMPUTED not in text
    assert "no median" not in text
    text = fe_maps.page(table, table, ["one sheet", "another"], ["another"])
    assert text.count(row) == 1
    assert "**1 of 2 cases are not computed." in text
    assert text.count(f"| another | {fe_maps.NOT_COMPUTED} |") == 2


def test_a_point_that_is_missed_or_unstable_is_counted():
    sheet = fe_maps.map_cases()[0].specimen.with_milestones([1.01])
    shell = solve(sheet, "dshell")
    named = {name: ("prestretch", [0.0]) for name in ("factorisations", "cpu_time")}
    result = shell.assign(named | {"stabilised_steps": ("prestretch", [0])})
    assert fe_maps.cost_row(result)["missed"] == fe_maps.cost_row(result)["unstable"] == 0
    result["unstable_modes"][:] = 2
    assert fe_maps.cost_row(result)["unstable"] == 1
    result["converged"][:] = 0
    row = fe_maps.cost_row(result)
    assert (row["reached"], row["missed"], row["unstable"]) == ("0 of 1", 1, 0)
