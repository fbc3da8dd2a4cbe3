"""A milestone that is taken out of a result is a result of one milestone."""

from dataclasses import replace

import pytest
import xarray as xr
from made_results import cap_result

from bilayer import MeshSize, paper_specimen, solve
from bilayer.exports.conversion import convert, convert_milestones
from bilayer.results.comparison import compare
from bilayer.results.milestones import along_milestones
from bilayer.results.report import provenance, result_table


def solved(solver):
    specimen = replace(paper_specimen(), mesh=MeshSize(0.02)).with_milestones([1.001, 1.002])
    return solve(specimen, solver)


@pytest.mark.parametrize("solver", ["dshell", "fenics"])
def test_every_variable_is_where_it_was(solver):
    if solver == "fenics":
        pytest.importorskip("dolfinx")
    result = solved(solver)
    for k in range(2):
        alone = along_milestones(result.isel(prestretch=k))
        xr.testing.assert_identical(alone, result.isel(prestretch=[k]))
    assert along_milestones(result) is result


def test_a_milestone_alone_is_told_of_and_written(tmp_path):
    result = cap_result(reached=1.065)
    one = result.sel(prestretch=1.06)
    row = result_table(result).splitlines()[3]
    assert result_table(one).splitlines()[2].split() == row.split()
    assert "milestones  1 of 1 reached" in provenance(one)
    convert(one, tmp_path / "one.vtu")
    convert(result, tmp_path / "same.vtu", 1.06)
    assert (tmp_path / "one.vtu").read_bytes() == (tmp_path / "same.vtu").read_bytes()


def test_a_prestretch_that_comes_again_keeps_its_own_shape(tmp_path):
    """As on a load path that goes up and down."""
    result = cap_result()
    loop = result.isel(prestretch=[0, 1, 0])
    loop["position"][2] *= 2
    names = [path.name for path in convert_milestones(loop, tmp_path / "shape.vtu")]
    assert names == ["shape_1.03.vtu", "shape_1.06.vtu", "shape_1.03_2.vtu"]
    assert len({(tmp_path / name).read_bytes() for name in names}) == 3
    compared = compare(loop, result.isel(prestretch=[0, 0, 1]))
    assert compared["prestretch"].values.tolist() == [1.03, 1.06, 1.03]
    assert (compared["rms_distance"].values[:2] < 1e-12).all()
    assert compared["rms_distance"].values[2] > 1e-3
