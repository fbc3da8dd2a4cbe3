"""The solid in contact with itself: a strip that rolls up until its end presses on it."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("dolfinx")
from mpi4py import MPI
from scipy.spatial.transform import Rotation

from bilayer import (
    MeshSize,
    follow,
    generate_mesh,
    open_result,
    paper_specimen,
    read_specimen,
    solve,
    write_result,
)
from bilayer.contact.package import contact_is_installed
from bilayer.geometry.alignment import rms_distance
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface
from bilayer.results.caveats import touches_itself
from bilayer.results.report import describe_trust
from bilayer.solvers.registry import settings_class
from fenics_model.contact.solid_skin import SolidSkin
from fenics_model.release.specimen_solid import extrude_layers
from fenics_model.settings import SolidSettings
from fenics_model.solid.state import State
from fenics_model.solver import open_path

EXAMPLES = Path(__file__).parents[2] / "examples"
BARRIER = SolidSettings(contact="barrier")
CLEAR, PRESSED = 0, 1
"""The example's milestones, before and after the first contact."""
CROSSED = (1.18, 1.0)
"""Prestretch at which the strip passes through itself without contact."""


@pytest.fixture(scope="module", autouse=True)
def needs_ipctk():
    if not contact_is_installed():
        pytest.skip("needs ipctk")


@pytest.fixture(scope="module")
def strip():
    return read_specimen(EXAMPLES / "rolled_strip.toml")


@pytest.fixture(scope="module")
def mesh(strip):
    return generate_mesh(strip)


@pytest.fixture(scope="module")
def shell(strip, mesh):
    return solve(strip, "dshell", settings_class("dshell")(contact="barrier"), mesh=mesh)


@pytest.fixture(scope="module")
def result(strip, mesh, shell):
    return solve(strip, "fenics", BARRIER, mesh=mesh, start=shell)


@pytest.fixture(scope="module")
def saved_and_live(strip, mesh, shell):
    """What is saved before the first contact, and the equilibrium in contact, live."""
    path = follow(strip, "fenics", BARRIER, mesh=mesh, start=shell)
    milestones = (point for point in path if point.share == 1)
    saved = next(milestones).save()
    yield saved, next(milestones)
    path.close()


@pytest.fixture
def live(saved_and_live):
    return saved_and_live[1]


@pytest.fixture(params=["disc", "trilayer"])
def sheet(request):
    if request.param == "disc":
        return replace(paper_specimen(), mesh=MeshSize(0.016))
    return replace(read_specimen(EXAMPLES / "trilayer_lotus.toml"), mesh=MeshSize(0.005))


def test_the_skin_is_closed_and_holds_the_body(sheet):
    mesh = generate_mesh(sheet)
    volume = extrude_layers(sheet, mesh, SolidSettings())
    skin = SolidSkin.of(volume, mesh)
    surface = Surface(skin.flat, skin.triangles)
    assert np.abs(surface.area_vectors.sum(axis=0)).max() < 1e-12 * surface.areas.sum()
    held = np.einsum("ij,ij->", surface.area_vectors, surface.corners.mean(axis=1)) / 3
    a, b, c, d = np.moveaxis(volume.points[volume.cells], 1, 0)
    whole = np.abs(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a)).sum() / 6
    assert held == pytest.approx(whole, rel=1e-12)


def test_it_knows_what_it_covers(sheet):
    mesh = generate_mesh(sheet)
    skin = SolidSkin.of(extrude_layers(sheet, mesh, SolidSettings()), mesh)
    centres = skin.flat[skin.triangles].mean(axis=1)[:, :2]
    a, b, c = np.moveaxis(mesh.points[mesh.triangles[skin.face]], 1, 0)
    for one, other in ((a, b), (b, c), (c, a)):
        side, away = other - one, centres - one
        assert (side[:, 0] * away[:, 1] - side[:, 1] * away[:, 0] > -1e-12).all()
    assert set(skin.face) == set(range(len(mesh.triangles)))


def test_points_over_one_place_are_one_fibre_and_fibres_beside_it_are_near(sheet):
    mesh = generate_mesh(sheet)
    skin = SolidSkin.of(extrude_layers(sheet, mesh, SolidSettings()), mesh)
    place = np.full((skin.fibre.max() + 1, 2), np.nan)
    place[skin.fibre] = skin.flat[:, :2]
    assert np.abs(place[skin.fibre] - skin.flat[:, :2]).max() < 1e-15
    one, other = place[skin.neighbours].swapaxes(0, 1)
    sides = mesh.points[mesh.edges]
    longest = np.linalg.norm(sides[:, 0] - sides[:, 1], axis=1).max()
    assert np.linalg.norm(one - other, axis=1).max() <= longest / 2 * (1 + 1e-12)


def test_every_milestone_is_reached_stable_and_crosses_nothing(result):
    assert result["converged"].values.all()
    assert (result["unstable_modes"].values == 0).all()
    assert (result["contact_crosses"].values == 0).all()
    assert (result["iterations"].values <= 25).all()


def test_before_the_first_contact_nothing_changes(strip, mesh, result):
    without = solve(
        strip.with_milestones([strip.prestretch.milestones[CLEAR]]), "fenics", mesh=mesh
    )
    change = result["position"].values[CLEAR] - without["position"].values[0]
    assert np.abs(change).max() < 1e-8 * strip.characteristic_length
    assert result["contact_pairs"].values[CLEAR] == 0
    assert np.isinf(result["contact_gap"].values[CLEAR])


def test_a_sheet_far_from_itself_takes_the_same_steps():
    disc = replace(paper_specimen(), mesh=MeshSize(0.016)).with_milestones([1.03])
    mesh = generate_mesh(disc)
    start = solve(disc, "dshell", mesh=mesh)
    free, apart = (
        solve(disc, "fenics", each, mesh=mesh, start=start) for each in (SolidSettings(), BARRIER)
    )
    assert np.array_equal(free["position"].values, apart["position"].values)
    assert free["iterations"].values[0] == apart["iterations"].values[0]


def test_the_result_tells_of_the_contact(result, mesh):
    assert 0 < result["contact_gap"].values[PRESSED] < 0.1e-3
    assert result["contact_force"].values[PRESSED] == pytest.approx(74e-6, rel=0.02)
    pressure = result["contact_pressure"].values[PRESSED]
    assert pressure.shape == (len(mesh.triangles),)
    assert 0 < pressure.max() < 1e4
    energy = result["energy"]
    share = energy.sel(term="contact") / energy.sum("term")
    assert share.values[CLEAR] == 0
    assert 0 < share.values[PRESSED] < 1e-3
    assert not touches_itself(result).any()
    assert "presses on itself at 1.14" in describe_trust(result)


def test_both_solvers_press_alike(result, shell, mesh):
    weights = flat_surface(mesh).node_areas
    apart = rms_distance(result["position"].values[1], shell["position"].values[1], weights)
    assert apart < 0.02 * 20e-3
    assert (shell["contact_pairs"].values > 0).tolist() == [False, True]


def test_the_force_is_the_derivative_of_the_energy(live):
    """That of the barrier alone, and the residual by the tangent, along some directions."""
    path = live._path
    newton, contact, state = path._newton, path.contact, live._point.state
    rng, step = np.random.default_rng(0), 2e-8
    force = contact.by_dofs(state, contact.at(state).gradient)
    way = rng.normal(size=len(force)) * (force != 0)
    near, far = (
        [contact.at(state + sign * size * way).energy for sign in (1, -1)]
        for size in (step, 2 * step)
    )
    slope = (8 * (near[0] - near[1]) - (far[0] - far[1])) / (12 * step)
    assert slope == pytest.approx(force @ way, rel=1e-7)
    way = rng.normal(size=len(force))
    way[newton.held_dofs] = 0.0
    near, far = (
        [newton.residual(state + sign * size * way) for sign in (1, -1)]
        for size in (step, 2 * step)
    )
    change = (8 * (near[0] - near[1]) - (far[0] - far[1])) / (12 * step)
    with newton.factorise(state) as factors:
        expected = newton.layout.times(factors.matrix, way)
    expected[newton.held_dofs] = 0.0
    assert np.abs(change - expected).max() < 1e-7 * np.abs(expected).max()


def test_the_pressed_forces_are_in_balance_and_turn_with_the_body(live):
    contact, state = live._path.contact, live._point.state
    here, points = contact.at(state), contact.points(state)
    size = np.abs(here.gradient).sum()
    assert np.abs(here.gradient.sum(axis=0)).max() < 1e-8 * size
    assert np.abs(np.cross(points, here.gradient).sum(axis=0)).max() < 1e-8 * size * 0.02
    turn = Rotation.from_rotvec([0.7, -1.9, 0.4])
    there = contact.barrier.at(turn.apply(points) + np.array([3e-3, -2e-3, 1e-3]))
    assert there.energy == pytest.approx(here.energy, rel=1e-9)
    turned = turn.apply(here.gradient)
    assert np.abs(there.gradient - turned).max() < 1e-9 * np.abs(turned).max()


def test_a_path_goes_on_from_a_saved_one_into_contact(strip, mesh, saved_and_live):
    saved, live = saved_and_live
    again = open_path(strip, BARRIER, mesh=mesh, start=None, comm=MPI.COMM_WORLD, progress=None)
    again.restore(saved)
    *_, found = again.approach(strip.prestretch.milestones[PRESSED])
    assert np.array_equal(found._point.state.values, live._point.state.values)
    again.close()


def test_no_flow_begins_from_a_shape_that_passes_through_the_strip(strip, mesh):
    """A viscous flow would keep what is inside inside; one from the flat strip begins."""
    crossing = solve(strip.with_milestones([CROSSED]), "dshell", mesh=mesh)
    assert touches_itself(crossing).all()
    path = open_path(strip, BARRIER, mesh=mesh, start=None, comm=MPI.COMM_WORLD, progress=None)
    path.body.prestretch(strip, CROSSED)
    guide, flat = path._guide, mesh.points @ np.eye(2, 3)
    guide.use_shapes({0.18: crossing["position"].values[0], 0.1: flat})
    guide._guess = guide._state_at(0.18)
    flowed = guide.flow_from_shape(0.18, 1e-3, 1e-3, "too many iterations")
    assert flowed.equilibrium is None
    assert flowed.effort.iterations == 0
    assert guide.rejected == [(0.18, "too many iterations")]
    guide._guess = guide._state_at(0.1)
    assert guide.flow_from_shape(0.1, 1e3, 1e3, "none").effort.iterations > 0
    path.close()


def test_a_step_ahead_stops_short_of_what_the_skin_would_pass_through(live):
    """From where the strip presses on itself, a little apart and far into itself."""
    newton, state = live._path._newton, live._point.state
    force = live._path.contact
    pressed = force.by_dofs(state, force.at(state).gradient)
    into = pressed * (2e-3 / np.abs(pressed).max())
    away = state + -0.01 * into
    assert newton.reach(state, away) is away
    short = newton.reach(state, state + into)
    assert not newton.passes_through(short)
    assert 0 < np.abs(short - state).max() < np.abs(into).max()


def test_the_equations_near_an_equilibrium_have_the_barrier_in_them(live):
    numbering, held = live._path.numbering, live._path._newton.held_dofs
    side = np.random.default_rng(0).normal(size=numbering.size)
    local = numbering.spread(side)
    local[held] = 0.0
    solved = State(numbering.spread(live.linearised().solve(side)))
    with live._path._newton.factorise(live._point.state) as factors:
        found = live._path._newton.layout.times(factors.matrix, solved.values)
    assert found == pytest.approx(local, abs=1e-6)


def test_without_the_package_the_run_says_what_to_install(strip, mesh, monkeypatch):
    monkeypatch.setitem(sys.modules, "ipctk", None)
    result = solve(strip.with_milestones([CROSSED]), "fenics", BARRIER, mesh=mesh)
    assert touches_itself(result).all()
    assert "pip install 'bilayer-shells[contact]'" in describe_trust(result)


def test_two_ranks_that_share_the_strip_give_what_one_gives(
    bilayer_on_ranks, tmp_path, shell, result
):
    write_result(shell, tmp_path / "shell.nc")
    options = "--set solver.contact=barrier --start shell.nc --mesh shell.nc -o two.nc --quiet"
    strip = EXAMPLES / "rolled_strip.toml"
    bilayer_on_ranks(2, "solve", strip, "--solver", "fenics", *options.split())
    shared = open_result(tmp_path / "two.nc")
    for name in ("position", "volume_position"):
        assert shared[name].values == pytest.approx(result[name].values, abs=1e-9)
    for name in ("iterations", "unstable_modes", "converged", "contact_pairs", "contact_crosses"):
        assert shared[name].values.tolist() == result[name].values.tolist()
    force = result["contact_force"].values
    assert shared["contact_force"].values == pytest.approx(force, rel=1e-6)
