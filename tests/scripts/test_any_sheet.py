"""The table of the solvers on other sheets: states, finer meshes, rows, the loss of symmetry."""

from dataclasses import replace
from pathlib import Path

import any_sheet
import numpy as np
import pytest
from made_results import cap_result, small_specimen
from shapes import cylinder
from sheet_comparison.branches import energy, in_one_state
from sheet_comparison.cases import MILESTONES, Case, cases, softened
from sheet_comparison.cross import SIZES, CrossRow, height_without_mesh, loses_symmetry_at
from sheet_comparison.page import page
from sheet_comparison.rows import Row, on_finest_mesh, rows_on
from sheet_comparison.table import read_table, write_table
from sheet_comparison.walls import WallRow, beside, is_missed

from bilayer import ComputationError, result_mesh

ROOT = Path(__file__).parents[2]
TOLERANCE = 0.005


@pytest.fixture(scope="module")
def dome():
    """The finite-element model's own state."""
    return cap_result(small_specimen((1.06,)), solver="fenics")


@pytest.fixture(scope="module")
def roll(dome):
    """The shell's own state, far from the other one."""
    mesh = result_mesh(dome)
    return cap_result(
        small_specimen((1.06,)), mesh=mesh, motion=lambda shape: cylinder(mesh.points, 0.5)
    )


def near(result, share=1.001, of_energy=1.0):
    """Return a result whose shape is a little larger, with so much of its energy."""
    return result.assign(position=share * result["position"], energy=of_energy * result["energy"])


def never(solver, start):
    raise AssertionError("solvers that agree are not started anew")


def leads_to(**states):
    return lambda solver, start: states[solver]


def test_solvers_that_agree_are_in_one_state(dome):
    pair = in_one_state(dome, near(dome), TOLERANCE, never)
    assert pair.state == "both"
    assert np.isnan(pair.excess_solid)
    assert 0 < pair.distance < TOLERANCE


@pytest.mark.parametrize(("of_roll", "state"), [(1.1, "fenics"), (0.9, "dshell")])
def test_the_state_of_lower_energy_by_the_finite_elements_is_taken(dome, roll, of_roll, state):
    solids, shells = (dome, near(roll, of_energy=of_roll)), (near(dome), roll)
    solve_from = leads_to(fenics=solids[1], dshell=shells[0])
    pair = in_one_state(dome, roll, TOLERANCE, solve_from)
    assert pair.state == state
    assert pair.distance < TOLERANCE
    other = solids[state == "fenics"]
    assert pair.excess_solid == pytest.approx(energy(other) / energy(pair.solid) - 1)
    assert pair.excess_solid > 0
    assert pair.excess_shell == pytest.approx(0.0)


def test_solvers_that_stay_apart_in_their_states_are_taken_as_they_are(dome, roll):
    pair = in_one_state(dome, roll, TOLERANCE, leads_to(fenics=dome, dshell=roll))
    assert (pair.state, pair.solid, pair.shell) == ("both", dome, roll)
    assert pair.distance > TOLERANCE


def test_a_solver_that_fails_from_the_other_shape_keeps_its_own(dome, roll):
    def solve_from(solver, start):
        if solver == "dshell":
            raise ComputationError("no convergence")
        return near(roll, of_energy=0.9)

    pair = in_one_state(dome, roll, TOLERANCE, solve_from)
    assert (pair.state, pair.shell) == ("dshell", roll)
    assert np.isnan(pair.excess_shell)


def row(**fields):
    found = (0.001, 0.0003, 0.35, 0.35, 0.99, np.nan, np.nan, 0, 0, np.inf)
    return replace(Row("square", "bilayer", 0.05, 0, 1.03, 2.5e-3, 610, "both", *found), **fields)


def test_rows_are_read_as_they_were_written(tmp_path):
    rows = [row(excess_fenics=-1e-5, excess_shell=0.1), row(prestretch=1.06)]
    write_table(tmp_path / "rows.csv", rows)
    assert repr(read_table(tmp_path / "rows.csv", Row)) == repr(rows)
    assert read_table(tmp_path / "none.csv", Row) == []


def test_the_finest_mesh_of_each_sheet_counts():
    case = Case("square", "bilayer", 0.05)
    rows = [row(distance=0.01), row(mesh_size=case.finer.specimen.mesh.size), row(sheet="ellipse")]
    assert on_finest_mesh(rows) == rows[1:]
    assert rows_on(rows, case) == rows[:1]
    assert rows_on(rows, case.finer) == rows[1:2]


def test_the_solvers_are_compared_on_finer_meshes_while_they_disagree(tmp_path, monkeypatch):
    distances = iter((0.004, 0.02, 0.003, 0.01, 0.002, 0.004, 0.001, 0.001))

    def rows_of(case, kept):
        for stretch in MILESTONES:
            yield row(
                mesh_size=case.specimen.mesh.size, prestretch=stretch, distance=next(distances)
            )

    monkeypatch.setattr(any_sheet, "rows_of", rows_of)
    path = tmp_path / "rows.csv"
    rows = any_sheet.with_case([], Case("square", "bilayer", 0.05), tmp_path, path)
    assert [found.distance for found in rows] == [0.004, 0.02, 0.003, 0.01, 0.002, 0.004]
    assert len(read_table(path, Row)) == 6


def wall_row(**fields):
    found = ("square", "bilayer", 0.05, 0, 1.03, 2.5e-3, 0.001, 0.35, 1.0, 0)
    return replace(WallRow(*found), **fields)


def test_the_relieved_shell_is_judged_beside_the_other_one():
    walls = [wall_row(prestretch=1.06, distance=0.006), wall_row()]
    assert beside(row(), walls) is walls[1]
    assert not is_missed(row(distance=0.01), walls)
    assert is_missed(row(prestretch=1.06), walls)
    assert is_missed(row(sheet="ellipse"), walls)
    assert not is_missed(row(thickness=0.1), walls)


def test_the_relieved_shell_is_computed_where_it_is_missing(tmp_path, monkeypatch):
    asked = []

    def wall_rows(case, rows, kept):
        asked.extend(rows)
        return [wall_row(prestretch=found.prestretch) for found in rows]

    monkeypatch.setattr(any_sheet, "wall_rows", wall_rows)
    rows = [row(), row(prestretch=1.06), row(prestretch=1.2, distance=np.nan)]
    case, path = Case("square", "bilayer", 0.05), tmp_path / "walls.csv"
    walls = any_sheet.with_walls([wall_row()], rows, case, tmp_path, path)
    assert asked == rows[1:2]
    assert [found.prestretch for found in walls] == [1.03, 1.06]
    assert read_table(path, WallRow) == walls


def test_a_case_that_lacks_a_milestone_is_computed(tmp_path, monkeypatch):
    both = [row(prestretch=stretch) for stretch in MILESTONES]
    monkeypatch.setattr(any_sheet, "rows_of", lambda case, kept: both)
    case = Case("square", "bilayer", 0.05)
    assert any_sheet.with_case(both[:1], case, tmp_path, tmp_path / "rows.csv") == both


def test_the_kirigami_alone_becomes_softer():
    specimen = Case("cross on a square", "trilayer", 0.05).specimen
    softer = softened(specimen, 0.01)
    for before, after in zip(specimen.layers, softer.layers, strict=True):
        share = 1.0 if before.name == "substrate" else 0.99
        assert after.material.young_modulus == pytest.approx(share * before.material.young_modulus)
        assert after.material.poisson_ratio == pytest.approx(before.material.poisson_ratio)


def test_each_case_has_files_of_its_own():
    names = [case.file_name for first in cases() for case in (first, first.finer)]
    assert len(set(names)) == len(names)


def cross_row(size, stretch, height=0.4, corners=0.0):
    return CrossRow(size, 100, stretch, height, corners, 1e-6)


def test_a_loss_of_symmetry_is_where_the_square_of_the_amplitude_begins():
    stretches = np.array([1.02, 1.0275, 1.03, 1.0325, 1.035])
    amplitudes = np.sqrt(np.maximum(0.0, 9.0 * (stretches - 1.0285)))
    rows = [
        cross_row(SIZES[0], stretch, corners=amplitude)
        for stretch, amplitude in zip(stretches, amplitudes, strict=True)
    ]
    assert loses_symmetry_at(rows) == pytest.approx(1.0285)


@pytest.mark.parametrize("order", [1.0, 2.0, 3.5])
def test_the_limit_of_finer_meshes(order):
    rows = [cross_row(size, 1.03, 0.43 - 30.0 * size**order) for size in SIZES]
    assert height_without_mesh(rows, 1.03) == pytest.approx((0.43, order))


def test_the_page_is_that_of_the_numbers_that_are_kept():
    rows = read_table(ROOT / "results" / "any_sheet.csv", Row)
    cross = read_table(ROOT / "results" / "any_sheet_cross.csv", CrossRow)
    walls = read_table(ROOT / "results" / "any_sheet_walls.csv", WallRow)
    assert page(rows, cross, walls) == (ROOT / "docs" / "any_sheet.md").read_text()
