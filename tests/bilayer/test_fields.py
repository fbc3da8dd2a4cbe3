"""Fields of results: from the shapes alone, and of the layers by the solver that made them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from made_results import cap_result, half_angle

import bilayer
from bilayer.cli.main import main
from bilayer.mechanics.dataset import LAYER_FIELDS, SHAPE_FIELDS
from bilayer.mechanics.selection import ScalarField, scalar_field
from bilayer.results.files import write_result

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def caps() -> xr.Dataset:
    return cap_result(reached=1.06)


@pytest.fixture(scope="module")
def shell() -> xr.Dataset:
    specimen = replace(bilayer.paper_specimen(), mesh=bilayer.MeshSize(0.01))
    return bilayer.solve(specimen.with_milestones([1.05, 1.1]), "dshell")


@pytest.fixture(scope="module")
def found(shell) -> xr.Dataset:
    return bilayer.fields(shell)


def test_fields_of_a_cap(caps):
    """Two caps that were reached: curvature of their sphere, distance 0 from it."""
    fields = bilayer.fields(caps)
    assert set(SHAPE_FIELDS) <= set(fields) and not set(LAYER_FIELDS) & set(fields)
    for k, stretch in enumerate((1.03, 1.06)):
        curvature = half_angle(stretch) / 0.04
        assert fields["mean_curvature"][k].values == pytest.approx(curvature, rel=0.05)
        assert fields["gaussian_curvature"][k].values == pytest.approx(curvature**2, rel=0.1)
        assert np.abs(fields["sphere_distance"][k].values).max() < 1e-8
    assert np.isnan(fields["mean_curvature"][2].values).all()
    assert np.isnan(fields["normal"][2].values).all()


def test_the_prestretch_of_the_layers_is_told(caps):
    prestretch = bilayer.fields(caps)["layer_prestretch"].sel(component="zz").values
    assert prestretch[:, 0] == pytest.approx(np.array([1.03, 1.06, 1.09]) ** -2)
    assert (prestretch[:, 1] == 1).all()


def test_the_distance_from_another_result_is_that_after_a_rigid_motion(caps):
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    moved = cap_result(motion=lambda p: p @ turn.T + [0.1, 0, 0])
    distance = bilayer.fields(caps, moved)["distance_to_other"].values
    assert distance[:2] == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(distance[2]).all()
    larger = cap_result(motion=lambda p: 1.1 * p)
    assert bilayer.fields(caps, larger)["distance_to_other"].values[0].max() > 2e-3


def test_the_energy_density_integrates_to_the_energies(shell, found):
    held = (found["energy_density"] * found["natural_volume"]).sum("face").values
    energies = shell["energy"].values
    assert held.sum(axis=1) == pytest.approx(energies.sum(axis=1), rel=1e-10)
    assert held == pytest.approx(energies, rel=1e-8)  # a layer alone is not stationary
    assert (found["found_again"].values < 1e-9).all()


def test_states_of_a_released_shell_are_sensible(found):
    """In plane stress; only where the layer lies; nearly incompressible; thinner if stretched."""
    bare = np.isnan(found["energy_density"].values[:, 1])
    assert 0 < bare.mean() < 0.5 and not np.isnan(found["energy_density"].values[:, 0]).any()
    assert np.nanmax(np.abs(found["cauchy_stress"].sel(component="zz").values)) < 1e-6
    assert np.nanmax(np.abs(found["volume_ratio"].values - 1)) < 0.01
    trace = found["principal_stress"].sum("principal", skipna=False).values
    assert found["pressure"].values == pytest.approx(-trace / 3, nan_ok=True)
    assert (np.diff(found["principal_strain"].values, axis=-1)[~np.isnan(trace)] <= 0).all()
    length = np.linalg.norm(found["principal_stress_direction"].values, axis=-1)
    assert length[np.isfinite(length)] == pytest.approx(1.0)
    thickness = found["layer_thickness"].isel(prestretch=1).mean("face").values
    assert thickness == pytest.approx([1e-3 / 1.1**2, 1e-3], rel=0.15)


def test_one_milestone_alone(shell, found):
    one = bilayer.fields(shell.sel(prestretch=1.1))
    stress = one["cauchy_stress"].values[0]
    assert stress == pytest.approx(
        found["cauchy_stress"].values[1], rel=1e-5, abs=1e-2, nan_ok=True
    )


def test_a_shape_that_is_no_equilibrium_has_no_fields(shell):
    bent = shell.copy(deep=True)
    bent["position"] = bent["position"] * [1.0, 1.0, 0.5]
    with pytest.raises(bilayer.InputError, match=r"found again is .* from the shape"):
        bilayer.fields(bent)
    assert "mean_curvature" in bilayer.fields(bent, layers=False)


def test_models_without_layers_and_unknown_solvers_have_the_fields_of_shapes(shell):
    for solver, model in (("dshell", "hinge"), ("calculix", "deck")):
        other = shell.assign_attrs(solver=solver, model=model, settings="")
        assert "cauchy_stress" not in bilayer.fields(other)


@pytest.mark.slow
def test_a_file_of_an_earlier_version_has_its_fields():
    old = bilayer.open_result(ROOT / "results" / "paper" / "shell_morley.nc").isel(prestretch=[0])
    fields = bilayer.fields(old)
    held = (fields["energy_density"] * fields["natural_volume"]).sum(["face", "sheet_layer"])
    assert held.values == pytest.approx(old["energy"].sum("term").values, rel=1e-8)


@pytest.mark.parametrize(
    ("name", "unit", "location"),
    [
        ("cauchy_stress.substrate.top.xx", "kPa", "face"),
        ("principal_stress.first.kirigami.bottom", "kPa", "face"),
        ("energy_density.kirigami", "mJ/cm3", "face"),
        ("normal.z", "", "node"),
        ("mean_curvature", "1/mm", "node"),
    ],
)
def test_one_number_per_place(shell, found, name, unit, location):
    field = scalar_field(found, name)
    assert (field.unit, field.location) == (unit, location)
    mesh = bilayer.result_mesh(shell)
    assert field.on_nodes(mesh).shape == (2, len(mesh.points))
    assert field.on_faces(mesh).shape == (2, len(mesh.triangles))


def test_a_constant_of_the_faces_is_that_constant_at_the_nodes(shell, found):
    mesh = bilayer.result_mesh(shell)
    field = scalar_field(found, "energy_density.substrate")
    flat = replace(field, values=np.full_like(field.values, 3.0))
    assert flat.on_nodes(mesh) == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cauchy_stres", "did you mean 'cauchy_stress'"),
        ("cauchy_stress", "expected .sheet_layer after it, one of substrate, kirigami"),
        ("cauchy_stress.substrate.xx", "expected .level after it"),
        ("cauchy_stress.film.top.xx", "has 'film', expected one of substrate, kirigami"),
        ("mean_curvature.top", "has 'top', expected no more"),
        ("layer_prestretch.substrate.xx", "is one number for a whole layer"),
    ],
)
def test_what_a_name_lacks_is_said(found, name, message):
    with pytest.raises(bilayer.InputError, match=message):
        scalar_field(found, name)


@pytest.fixture(scope="module")
def file(shell, tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("fields") / "shell.nc"
    write_result(shell, path)
    return path


@pytest.mark.parametrize(
    ("name", "unit", "label"),
    [
        ("cauchy_stress.substrate.top.xx", "kPa", "Cauchy stress xx, substrate, top (kPa)"),
        ("principal_stress.first", "kPa", "first principal stress (kPa)"),
        ("energy_density.kirigami", "mJ/cm3", "energy density, kirigami (mJ/cm3)"),
        ("volume_ratio", "", "volume ratio"),
    ],
)
def test_a_label_is_what_a_reader_of_a_paper_understands(name, unit, label):
    assert ScalarField(name, unit, "face", np.zeros((1, 1))).label == label


def test_plot_and_view_draw_a_field(file, tmp_path, capsys):
    figure, page = tmp_path / "stress.png", tmp_path / "page.html"
    name = "principal_stress.substrate.top.first"
    assert main(["plot", str(file), "-o", str(figure), "--field", name]) == 0
    assert figure.stat().st_size > 10_000
    words = ["view", str(file), "-o", str(page), "--no-open", "--field", name]
    assert main([*words, "--field", "mean_curvature"]) == 0
    text = page.read_text()
    scene = json.loads(text[text.index('id="scene">') + 11 :].split("</script>")[0])
    fields = {field["name"]: field for field in scene["models"][0]["fields"]}
    assert fields["first principal stress, substrate, top"]["unit"] == "kPa"
    assert fields["mean curvature"]["high"] > fields["mean curvature"]["low"]


def test_convert_writes_the_result_with_its_fields_which_are_then_there(file, tmp_path, capsys):
    whole = tmp_path / "whole.nc"
    assert main(["convert", str(file), "-o", str(whole), "--fields"]) == 0
    held = bilayer.open_result(whole)
    assert held["cauchy_stress"].attrs["units"] == "Pa"
    assert set(LAYER_FIELDS) | set(SHAPE_FIELDS) <= set(held)
    capsys.readouterr()
    words = ["plot", str(whole), "-o", str(tmp_path / "a.png"), "--field", "pressure.kirigami.top"]
    assert main(words) == 0
    assert "again" not in capsys.readouterr().err
    assert main(["convert", str(file), "-o", str(tmp_path / "no.nc")]) == 2
    assert "expected --fields" in capsys.readouterr().err


def test_a_field_that_a_model_has_not(shell, tmp_path, capsys):
    hinge = tmp_path / "hinge.nc"
    write_result(shell.assign_attrs(model="hinge", settings=""), hinge)
    words = ["plot", str(hinge), "-o", str(tmp_path / "a.png")]
    assert main([*words, "--field", "pressure.kirigami.top"]) == 2
    assert "have no strains and stresses" in capsys.readouterr().err
    assert main([*words, "--field", "mean_curvature"]) == 0
