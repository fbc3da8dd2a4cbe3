"""The zones beside walls: what they do to strips, to any mesh, and to the derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from verification import derivatives, wall_strip
from verification.meshes import rectangle

import bilayer
from bilayer import InputError, MeshSize, PlanarMesh, generate_mesh, solve
from bilayer.specimen.relaxation import PronySeries
from dshell import MorleySettings
from dshell.models.morley import MorleyModel
from dshell.models.wall_faces import walls_of

RELIEVED = MorleySettings(walls="relieved")
STRETCH = (1.05, 1.03)


@pytest.fixture(scope="module")
def sheet():
    kirigami = bilayer.Layer("kirigami", 1e-3, wall_strip.KIRIGAMI.material,
                             pattern=bilayer.Cross(0.01))  # fmt: skip
    layers = [wall_strip.SUBSTRATE, kirigami]
    outline = bilayer.Rectangle(0.04, 0.03)
    return bilayer.Specimen(outline, layers, bilayer.Prestretch((1.03,)), MeshSize(0.01))


@pytest.fixture(scope="module")
def mesh(sheet):
    return generate_mesh(sheet)


def energy_of(model, state):
    return sum(float(faces.at(state).energy().sum()) for faces in model.energies(STRETCH))


def test_without_the_setting_there_are_no_zones(sheet, mesh):
    (faces,) = MorleyModel(sheet, mesh, MorleySettings()).energies(STRETCH)
    assert faces.laminate.zones is None
    assert MorleySettings().walls == "strained"


def test_derivatives_and_rigid_motion(sheet, mesh):
    model = MorleyModel(sheet, mesh, RELIEVED)
    (faces,) = model.energies(STRETCH)
    state = derivatives.rough_dome(mesh, model.extra_dofs)
    assert derivatives.gradient_error(faces, state) < 1e-7
    assert derivatives.hessian_error(faces, state) < 1e-7
    assert derivatives.rigid_motion_error(faces, state, len(mesh.points)) < 1e-9


def test_the_energies_of_layers_and_zones_are_all(sheet, mesh):
    model = MorleyModel(sheet, mesh, RELIEVED)
    state = derivatives.rough_dome(mesh, model.extra_dofs)
    terms = model.energy_terms(STRETCH, state)
    assert set(terms) == {"substrate", "kirigami", "beside walls"}
    assert sum(terms.values()) == pytest.approx(energy_of(model, state), rel=1e-12)


def test_a_turned_sheet_has_the_same_energy(sheet):
    """A face in a corner of the cross shares two walls alike."""
    x = np.linspace(-0.02, 0.02, 9)
    mesh = rectangle(x, x)
    middle = np.abs(mesh.points[mesh.triangles].mean(axis=1)).min(axis=1)
    mesh = PlanarMesh(mesh.points, mesh.triangles, np.where(middle < 0.005, 1, 0))
    turn = Rotation.from_rotvec([0, 0, 0.7]).as_matrix()
    turned = PlanarMesh(mesh.points @ turn[:2, :2].T, mesh.triangles, mesh.region, mesh.layer_sets)
    whole = replace(sheet, prestretch=bilayer.Prestretch((1.03,)))
    first, second = (MorleyModel(whole, each, RELIEVED) for each in (mesh, turned))
    state = derivatives.rough_dome(mesh, first.extra_dofs)
    nodes = 3 * len(mesh.points)
    moved = np.concatenate([(state[:nodes].reshape(-1, 3) @ turn.T).reshape(-1), state[nodes:]])
    here, there = (
        sum(float(f.at(s).energy().sum()) for f in model.energies((1.03, 1.03)))
        for model, s in ((first, state), (second, moved))
    )
    assert there == pytest.approx(here, rel=1e-9)


@pytest.mark.parametrize("size", [0.01, 0.004, 0.001])
def test_faces_share_all_the_length_of_the_walls_on_any_mesh(sheet, size):
    mesh = generate_mesh(replace(sheet, mesh=MeshSize(size)))
    walls = walls_of(mesh, 2e-3, np.empty((0, 2), dtype=np.int64))
    length = {
        (len(wall.there), len(wall.ending)): float(
            (mesh.areas[wall.behind.faces] * wall.behind.density).sum()
        )
        for wall in walls
    }
    expected = {(2, 1): 0.1, (1, 1): 0.1, (2, 2): 0.04}
    assert length == pytest.approx(expected, rel=1e-6)


def test_a_clamped_edge_is_no_wall(mesh):
    walls = walls_of(mesh, 2e-3, mesh.boundary_edges)
    assert [len(wall.ending) for wall in walls] == [1]


def test_a_wall_turns_the_bar_by_the_same_however_wide_it_is_and_however_fine_the_mesh():
    """0.56 thicknesses of the kirigami, by the section and by finite elements (rung 26)."""
    for width in (4.8e-3, 19.2e-3):
        for cells in (2, 7, 32):
            taken = wall_strip.missing(wall_strip.shell_angle(width, cells), width)
            assert taken == pytest.approx(-0.5614, abs=2e-3)


@pytest.mark.parametrize("width", [0.5, 1.0, 2.0, 4.0])
def test_torsion_of_a_strip_is_st_venants(width):
    found = wall_strip.torsion(width)
    assert found == pytest.approx(wall_strip.st_venant(width), abs=0.03)


def test_a_released_sheet_moves_a_little(sheet, mesh):
    plain, relieved = (solve(sheet, "dshell", each, mesh=mesh) for each in (None, RELIEVED))
    assert relieved.converged.item() == 1
    assert relieved.term.values.tolist() == ["substrate", "kirigami", "beside walls"]
    moved = bilayer.compare(plain, relieved)["rms_distance_over_radius"].item()
    assert 1e-4 < moved < 0.05


def test_places_of_nodes_have_no_derivative(sheet, mesh):
    model = MorleyModel(sheet, mesh, RELIEVED)
    state = derivatives.rough_dome(mesh, model.extra_dofs)
    with pytest.raises(InputError, match=r"solver\.walls = 'relieved'"):
        model.flat_gradient(STRETCH, state)


def test_a_layer_that_relaxes_is_refused(sheet, mesh):
    relaxing = sheet.with_layer("substrate", relaxation=PronySeries([(0.3, 10.0)]))
    with pytest.raises(InputError, match="the layer substrate relaxes"):
        MorleyModel(relaxing, mesh, RELIEVED)


def test_a_bad_setting_is_named():
    with pytest.raises(InputError, match=r"solver\.walls = 'free': expected one of 'strained', "):
        MorleySettings(walls="free")


def test_a_file_from_before_the_setting_is_taken_up(sheet, mesh, tmp_path):
    file = tmp_path / "old.nc"
    result = solve(sheet, "dshell", mesh=mesh, output=file)
    lines = result.attrs["settings"].splitlines()
    result.attrs["settings"] = "\n".join(line for line in lines if "walls" not in line)
    bilayer.write_result(result, file)
    again = solve(sheet, "dshell", mesh=mesh, resume=file)
    assert np.array_equal(again.position, result.position)
    with pytest.raises(InputError, match="another settings"):
        solve(sheet, "dshell", RELIEVED, mesh=mesh, resume=file)
