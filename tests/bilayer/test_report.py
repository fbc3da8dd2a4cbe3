"""The text of a result: how far it can be trusted."""

from dataclasses import replace

import pytest
from made_results import cap_result, small_specimen

from bilayer import MeshSize, generate_mesh
from bilayer.cli.main import main
from bilayer.results.caveats import THICKEST_SHELL
from bilayer.results.report import describe_trust, provenance
from bilayer.results.sheet_report import sheet_report
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import template


def of_thickness(share: float) -> Specimen:
    """Return a specimen of layers that are together as thick as a share of its radius."""
    half = share * 0.04 / 2
    return (
        small_specimen().with_layer("substrate", thickness=half)
        .with_layer("kirigami", thickness=half)
    )  # fmt: skip


@pytest.mark.parametrize(("solver", "warned"), [("dshell", True), ("fenics", False)])
def test_a_shell_of_a_thick_sheet_is_not_trusted(solver, warned):
    result = cap_result(of_thickness(1.2 * THICKEST_SHELL), solver=solver)
    assert ("TOO THICK FOR A SHELL" in describe_trust(result)) is warned
    assert (f"{1.2 * THICKEST_SHELL:.1%} of the radius" in provenance(result)) is warned


@pytest.mark.parametrize("specimen", [small_specimen(), of_thickness(THICKEST_SHELL)])
def test_a_shell_of_a_thin_sheet_is(specimen):
    assert "THICK" not in describe_trust(cap_result(specimen))


@pytest.mark.parametrize(("solver", "warned"), [("dshell", True), ("fenics", False)])
def test_a_shell_that_turns_sharply_from_triangle_to_triangle_is_not_trusted(solver, warned):
    trust = describe_trust(cap_result(small_specimen((1.03, 1.6)), solver=solver))
    assert ("TOO COARSE FOR THE CURVATURE at 1.6:" in trust) is warned


def test_a_finer_mesh_of_it_is():
    specimen = replace(small_specimen((1.6,)), mesh=MeshSize(0.005))
    assert "COARSE" not in describe_trust(cap_result(specimen))


def test_the_mesh_of_a_shape_that_was_not_reached_is_not_judged():
    trust = describe_trust(cap_result(small_specimen((1.03, 1.6)), reached=1.03))
    assert "COARSE" not in trust


def test_a_pattern_that_only_the_mesh_has_is_told():
    specimen = small_specimen()
    whole = specimen.with_layer("kirigami", pattern=None)
    told = provenance(cap_result(whole, mesh=generate_mesh(specimen)))
    assert "DEFINES THE PATTERN of kirigami, which lies on 7" in told
    assert "DEFINES" not in provenance(cap_result(specimen))
    assert "DEFINES" not in provenance(cap_result(whole))


def test_a_sheet_is_told_before_it_is_solved(tmp_path, capsys):
    path = tmp_path / "s.toml"
    path.write_text(template().replace('name = "paper"', 'name = "a\\nfake     line"'))
    assert main(["info", str(path)]) == 0
    told = capsys.readouterr().out
    assert "specimen    a\\nfake     line: radius 40 mm, 5 strips" in told
    assert "kirigami    lies on 77.1% of the area" in told
    assert "about 1548 triangles" in told
    assert told.endswith("Nothing in it is doubtful.\n")
    assert main(["info", str(path), "--specimen"]) == 0
    assert "[prestretch]" in capsys.readouterr().out
    assert main(["info", str(path), "--json"]) == 2
    assert capsys.readouterr().err.startswith("bilayer: error: --json: of a result, expected a .nc")


def test_what_is_doubtful_of_a_sheet_is_told():
    thick = of_thickness(1.2 * THICKEST_SHELL).with_milestones([1.03, 1.4])
    told = sheet_report(thick)
    assert "TOO THICK FOR A SHELL" in told
    assert "The law of the substrate is NOT STABLE" in told
