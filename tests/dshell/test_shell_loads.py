"""Loads and supports of the shell: derivatives, balance, known answers, paths up and down."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from verification import buckled_strip, clamped_plate, derivatives
from verification.buckled_strip import STRIP
from verification.meshes import disc
from verification.shell_problem import plate as plate_faces
from verification.shell_problem import single_layer

from bilayer import (
    InputError,
    Limit,
    Load,
    Part,
    Prestretch,
    Support,
    follow,
    generate_mesh,
    parse_specimen,
    solve,
)
from bilayer.results.released_shapes import released_shapes
from bilayer.results.schema import result_mesh
from dshell import HingeSettings, PaperSettings
from dshell.energies.grips import Grips
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.pressed_volume import PressedVolume


@pytest.fixture(scope="module")
def mesh():
    return disc(3, 0.01)


@pytest.fixture(scope="module")
def state(mesh):
    return derivatives.rough_dome(mesh, 0)


def grips_on(mesh):
    places = np.pad(mesh.points, ((0, 0), (0, 1)))
    return Grips(places, np.arange(0, 20, 3), np.array([0.6, 0.0, 0.8]), 40.0, 2e-3)


@pytest.mark.parametrize("make", [lambda mesh: PressedVolume(mesh.triangles, 70.0), grips_on])
def test_derivatives(make, mesh, state):
    term = make(mesh)
    assert derivatives.gradient_error(term, state) < 1e-7
    assert derivatives.hessian_error(term, state) < 1e-7


def test_derivatives_of_a_clamped_shell(mesh):
    faces, _ = plate_faces(mesh, [single_layer(1e6, 0.3, 1e-3)])
    inner = mesh.edges[np.isin(mesh.edges, mesh.triangles[4]).all(axis=1)]
    edges = np.unique(np.concatenate([mesh.boundary_edges[:9], inner]), axis=0)
    clamped = MorleyFaces(mesh.points, mesh.triangles, faces.laminate, edges)
    assert len(clamped.beyond) == 9 + 6
    places = np.pad(np.concatenate([mesh.points, clamped.beyond]), ((0, 0), (0, 1))).reshape(-1)
    flat = np.concatenate([places, np.zeros(clamped.edge_count)])
    rng = np.random.default_rng(2)
    state = flat + derivatives.ROUGHNESS * rng.uniform(-1, 1, len(flat))
    assert derivatives.gradient_error(clamped, state) < 1e-7
    assert derivatives.hessian_error(clamped, state) < 1e-7
    assert np.abs(clamped.at(state).gradient()[clamped.idle_dofs]).max() == 0


def test_the_work_of_a_pressure_on_a_closed_surface_is_that_on_its_volume():
    rng = np.random.default_rng(4)
    points = rng.normal(size=(40, 3)) * [1.0, 2.0, 0.5]
    hull = ConvexHull(points)
    outward = hull.equations[:, :3]
    a, b, c = points[hull.simplices].transpose(1, 0, 2)
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), outward) < 0
    triangles = np.where(turned[:, None], hull.simplices[:, ::-1], hull.simplices)
    term = PressedVolume(triangles, 5.0)
    moved = term.at((points + np.array([7.0, -3.0, 2.0])).reshape(-1))
    assert -moved.energy().sum() == pytest.approx(5.0 * hull.volume, rel=1e-12)
    forces = moved.gradient().reshape(-1, 3)
    assert forces.sum(axis=0) == pytest.approx([0, 0, 0], abs=1e-12)
    assert np.cross(points, forces).sum(axis=0) == pytest.approx([0, 0, 0], abs=1e-12)


@pytest.fixture(scope="module")
def blown():
    return solve(clamped_plate.plate_specimen(2.5e-3), "dshell")


def test_clamped_plate_in_large_deflections_is_that_of_von_karman(blown):
    middle = np.argmin(np.linalg.norm(blown.reference_position.values, axis=1))
    found = blown.position.values[:, middle, 2] / clamped_plate.THICKNESS
    expected = [clamped_plate.von_karman_deflection(load) for load in clamped_plate.LOADS]
    assert found == pytest.approx(expected, rel=0.05)  # 0.7 % at 1 mm
    assert blown.unstable_modes.values.tolist() == [0] * len(clamped_plate.LOADS)


def test_a_clamped_edge_neither_moves_nor_turns(blown):
    flat, shape = blown.reference_position.values, blown.position.values[-1]
    radius = np.linalg.norm(flat, axis=1)
    rim = radius > radius.max() - 1e-9
    assert np.abs(shape[rim] - flat[rim]).max() < 1e-12
    near = (radius < radius.max() - 1e-4) & (radius > radius.max() - 2.5e-3)
    rise = shape[near, 2] / (radius.max() - radius[near])  # of a hinged one 2 w / R and more
    assert rise.max() < 0.85 * shape[:, 2].max() / radius.max()


def test_the_energy_is_the_work_of_the_pressure_up_and_down():
    pressure = np.array([*np.linspace(0, 60, 13)[1:], 30.0, 0.0])
    sheet = clamped_plate.plate_specimen(4e-3)
    load = Load("blow", "pressure", tuple(pressure))
    result = solve(replace(sheet, prestretch=Prestretch([1.0]), loads=(load,)), "dshell")
    volume, energy = result.response_blow.values, result.energy.sum("term").values
    mean = (pressure + np.concatenate([[0], pressure[:-1]])) / 2
    work = np.cumsum(np.diff(volume, prepend=0) * mean)
    assert energy[11] == pytest.approx(work[11], rel=0.03)  # of straight pieces
    assert energy[12] == pytest.approx(energy[5], rel=1e-6)
    assert abs(energy[-1]) < 1e-9 * energy[11]


@pytest.fixture(scope="module")
def snapped():
    return solve(buckled_strip.specimen(3e-3), "dshell")


def test_a_buckled_strip_is_pushed_through_both_limit_points(snapped):
    assert snapped.converged.values.all()
    held = np.isfinite(snapped.load_poke.values)
    found = snapped.response_poke.values[held]
    expected = [STRIP.force_at(w) for w in snapped.load_poke.values[held]]
    assert found == pytest.approx(expected, rel=0.03)  # 0.6 % at 2 mm
    assert abs(snapped.response_poke.values[~held]).max() < 1e-9
    free = snapped.displacement_poke.values[~held]
    assert free == pytest.approx([STRIP.rise, -STRIP.rise, STRIP.rise], rel=0.01)


def test_a_run_under_loads_that_was_stopped_goes_on_as_if_it_had_not_been(snapped, tmp_path):
    def stop(step):
        if step.is_at_target and step.index == 4:
            raise KeyboardInterrupt

    strip, output = buckled_strip.specimen(3e-3), tmp_path / "snap.nc"
    with pytest.raises(KeyboardInterrupt):
        solve(strip, "dshell", observers=[stop], output=output)
    again = solve(strip, "dshell", output=output, resume=output)
    for name in ("position", "response_poke", "response_push", "displacement_poke"):
        assert np.array_equal(again[name].values, snapped[name].values)


def test_a_dead_force_snaps_where_displacement_control_has_its_greatest_force():
    text = buckled_strip.FILE.read_text(encoding="utf-8")
    begin = text.index("displacement = [\n")
    end = text.index("]\n", begin) + 2
    force = STRIP.snap[1]
    text = text[:begin] + f"force = [0.01, {0.9 * force}, {1.1 * force}]\n" + text[end:]
    result = solve(parse_specimen(text, ["mesh.size=0.003"]), "dshell")
    assert np.sign(result.response_poke.values).tolist() == [1, 1, -1]


def test_a_load_may_come_after_the_release_and_go_again(coarse_specimen, coarse_mesh):
    force = Load("press", "force", (0.0, -2e-3, 0.0), Part(limits=(Limit("r", "<=", 0.008),)))
    milestones = [1.06, 1.06, 1.06]
    loaded = replace(coarse_specimen.with_milestones(milestones), loads=(force,))
    points = list(follow(loaded, "dshell", mesh=coarse_mesh))
    found = {point.milestone: point.responses["press"] for point in points}
    assert found[(1.06, 1.06, -2e-3)] < found[(1.06, 1.06, 0.0)]


def test_a_bilayer_is_clamped_where_its_flat_reference_surface_is(coarse_specimen, coarse_mesh):
    rim = Support("rim", "clamped", Part("rim"))
    held = replace(coarse_specimen.with_milestones([1.0, 1.06]), supports=(rim,))
    result = solve(held, "dshell", mesh=coarse_mesh)
    flat = result.reference_position.values
    on_rim = coarse_mesh.rim_nodes
    assert np.abs(result.position.values[0] - flat).max() < 1e-9
    assert np.abs(result.position.values[1][on_rim] - flat[on_rim]).max() < 1e-4


def test_models_that_know_no_supports_say_so():
    plate = clamped_plate.plate_specimen(4e-3)
    with pytest.raises(InputError, match=r"supports.rim.kind = 'clamped': the model hinge keeps"):
        solve(plate, "dshell", HingeSettings())
    with pytest.raises(InputError, match="the paper's model has no supports"):
        solve(plate, "dshell", PaperSettings(), mesh=generate_mesh(plate))


def test_a_held_shape_is_shown_where_it_is_held_under_its_load():
    specimen = parse_specimen(
        """
        specimen.name = "cantilever"
        specimen.outline = { shape = "rectangle", width = "60 mm", height = "20 mm" }
        layers = [{ name = "sheet", thickness = "1 mm", material = "soft" }]
        materials.soft = { young_modulus = "1 MPa", poisson_ratio = 0.49 }
        supports.left = { kind = "clamped", where = { on = "rim", x = "<= -29 mm" } }
        loads.tip = { where = { on = "rim", x = ">= 29 mm" }, force = ["0 N", "-0.5 mN"] }
        mesh = { size = "8 mm" }
        """
    )
    result = solve(specimen, "dshell")
    flat, loaded = released_shapes(result, result_mesh(result))
    assert (flat.title, loaded.title) == ("λ = 1, tip 0 N", "λ = 1, tip -0.0005 N")
    x, _, z = loaded.surface.points.T
    np.testing.assert_allclose(z[x < -29], 0, atol=1e-6)
    assert z.min() == pytest.approx(1e3 * float(result["response_tip"][1]), rel=0.05)
