"""Comparison of two results: distances that are known, and what must not be compared."""

import re
from dataclasses import replace

import numpy as np
import pytest
from made_results import cap_result, half_angle, small_specimen
from scipy.spatial.transform import Rotation
from shapes import cap

from bilayer import CutPattern, Disc, InputError, MeshSize, generate_mesh
from bilayer.results.comparison import compare, comparison_table


def turned(position):
    return Rotation.from_rotvec([0.5, -1.0, 2.0]).apply(position) + np.array([0.1, 0.2, 0.3])


@pytest.fixture(scope="module")
def first():
    return cap_result(solver="fenics", model="mooney-rivlin")


def test_a_rigid_motion_is_no_difference(first):
    comparison = compare(first, cap_result(motion=turned))
    assert comparison["rms_distance"].values == pytest.approx(np.zeros(3), abs=1e-12)
    assert comparison["quality"].values[0] == pytest.approx(comparison["quality"].values[1])
    assert comparison.attrs["first"] == "fenics mooney-rivlin"
    assert comparison.attrs["second"] == "dshell paper"


def test_a_uniform_scaling_has_the_distance_of_its_radius_of_gyration(first):
    comparison = compare(first, cap_result(motion=lambda x: 1.01 * x))
    mesh = generate_mesh(small_specimen())
    weights = np.bincount(mesh.triangles.ravel(), np.repeat(mesh.areas / 3, 3))
    for k, stretch in enumerate((1.03, 1.06, 1.09)):
        shape = cap(mesh.points, half_angle(stretch))
        shape = shape - np.average(shape, axis=0, weights=weights)
        gyration = np.sqrt(np.average(np.sum(shape**2, axis=1), weights=weights))
        assert comparison["rms_distance"].values[k] == pytest.approx(0.01 * gyration, rel=1e-9)
    assert comparison["rms_distance_over_radius"].values == pytest.approx(
        comparison["rms_distance"].values / 0.04
    )


def test_only_common_milestones_are_compared(first):
    comparison = compare(first, cap_result(small_specimen((1.06, 1.09, 1.2))))
    assert comparison["prestretch"].values.tolist() == [1.06, 1.09]
    assert comparison["rms_distance"].values == pytest.approx([0, 0], abs=1e-12)


def test_a_milestone_that_one_has_not_reached_is_nan(first):
    comparison = compare(first, cap_result(reached=1.05))
    assert np.isfinite(comparison["rms_distance"].values).tolist() == [True, False, False]
    assert comparison["converged"].values.tolist() == [[1, 1, 1], [1, 0, 0]]
    assert np.isnan(comparison["quality"].values[1, 1:]).all()


def test_names_mesh_sizes_and_milestones_may_differ(first):
    specimen = replace(small_specimen((1.03,)), name="another", mesh=MeshSize(0.02))
    other = cap_result(specimen, mesh=generate_mesh(small_specimen()))
    assert compare(first, other).sizes["prestretch"] == 1


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s: replace(s, outline=Disc(0.041)), r"specimen\.outline\.radius = 0\.04 .* 0\.041"),
        (lambda s: s.with_layer("kirigami", pattern=CutPattern(4, 0.008, 0.3)),
         r"specimen\.layers\.kirigami\.pattern\.strips = 5 .* 4"),
        (lambda s: s.with_layer("kirigami", pattern=None),
         r"specimen\.layers\.kirigami\.pattern = CutPattern.* None"),
        (lambda s: s.with_layer("substrate", thickness=0.002),
         r"specimen\.layers\.substrate\.thickness = 0\.001 .* 0\.002"),
        (lambda s: replace(s, prestretch=replace(s.prestretch, thickness="constant")),
         r"specimen\.prestretch\.thickness = natural .* constant"),
    ],
)  # fmt: skip
def test_different_specimens_are_refused_by_field(first, change, message):
    with pytest.raises(InputError, match=message):
        compare(first, cap_result(change(small_specimen())))


def test_results_without_a_common_milestone_are_refused(first):
    with pytest.raises(InputError, match=r"1\.03, 1\.06, 1\.09 in the first .* 1\.2 in the second"):
        compare(first, cap_result(small_specimen((1.2,))))


def test_the_table_says_what_the_comparison_holds(first):
    comparison = compare(first, cap_result(motion=lambda x: 1.01 * x, reached=1.06))
    heading, groups, units, *rows = comparison_table(comparison).splitlines()
    assert heading == "a: fenics mooney-rivlin    b: dshell paper"
    assert "rms distance" in groups and "mm" in units and "% of R" in units
    assert len(rows) == 3
    cells = re.split(r"\s+", rows[0].strip())
    assert cells[0] == "1.03"
    assert float(cells[1]) == pytest.approx(1e3 * comparison["rms_distance"].values[0], abs=1e-3)
    assert float(cells[3]) == pytest.approx(comparison["quality"].values[0, 0], abs=1e-3)
    assert re.split(r"\s+", rows[2].strip())[1:3] == ["-", "-"]
