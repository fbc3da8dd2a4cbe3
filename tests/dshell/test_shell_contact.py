"""The shell in contact with itself: the paper's specimen beyond its first contact."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bilayer import (
    MeshSize,
    generate_mesh,
    open_result,
    paper_specimen,
    read_specimen,
    solve,
    write_result,
)
from bilayer.contact.package import contact_is_installed
from bilayer.errors import InputError
from bilayer.results.caveats import touches_itself
from bilayer.results.report import describe_trust, gap_words
from dshell.settings import HingeSettings, MorleySettings
from dshell.solver import open_path

needs_ipctk = pytest.mark.skipif(not contact_is_installed(), reason="needs ipctk")

MILESTONES = (1.21, 1.27, 1.30)
CROSSED = 1.36
"""Prestretch at which the sheet passes through itself without contact."""


@pytest.fixture(scope="module")
def specimen():
    return replace(paper_specimen().with_milestones(MILESTONES), mesh=MeshSize(0.006))


@pytest.fixture(scope="module")
def mesh(specimen):
    return generate_mesh(specimen)


@pytest.fixture(scope="module")
def run(specimen, mesh):
    """Return the result with contact, and the equilibria of its milestones."""
    if not contact_is_installed():
        pytest.skip("needs ipctk")
    points = []
    settings = MorleySettings(contact="barrier")
    observer = [lambda step: points.append(step.point)]
    result = solve(specimen, "dshell", settings, mesh=mesh, observers=observer)
    return result, [point for point in points if point.share == 1]


@pytest.fixture(scope="module")
def contact(run):
    return run[0]


@pytest.fixture(scope="module")
def equilibria(run):
    return run[1]


def test_every_milestone_is_reached_stable_and_crosses_nothing(contact):
    assert contact["converged"].values.all()
    assert (contact["unstable_modes"].values == 0).all()
    assert (contact["contact_crosses"].values == 0).all()
    assert (contact["iterations"].values[1:] <= 25).all()


def test_before_the_first_contact_nothing_changes(specimen, mesh, contact):
    free = solve(specimen.with_milestones(MILESTONES[:1]), "dshell", mesh=mesh)
    assert np.array_equal(contact["position"].values[0], free["position"].values[0])
    assert contact["iterations"].values[0] == free["iterations"].values[0]
    assert contact["contact_pairs"].values[0] == 0
    assert np.isinf(contact["contact_gap"].values[0])


def test_the_result_tells_of_the_contact(contact, mesh):
    gap, force = contact["contact_gap"].values[1:], contact["contact_force"].values
    assert ((gap > 0) & (gap < 0.1 * 2e-3)).all()
    assert force[0] == 0
    assert 0 < force[1] < force[2]
    pressure = contact["contact_pressure"].values
    assert pressure.shape == (len(MILESTONES), len(mesh.triangles))
    assert pressure[0].max() == 0
    assert 0 < pressure[2].max() < 1e5
    energy = contact["energy"]
    share = energy.sel(term="contact") / energy.sum("term")
    assert (share.values < 1e-3).all()
    assert share.values[2] > 0


def test_its_file_has_it_too(contact, tmp_path):
    write_result(contact, tmp_path / "touching.nc")
    read = open_result(tmp_path / "touching.nc")
    names = [name for name in contact if str(name).startswith("contact_")]
    assert len(names) == 5
    for name in names:
        assert np.array_equal(read[name].values, contact[name].values, equal_nan=True)


def test_the_text_of_the_result_says_so(contact):
    assert not touches_itself(contact).any()
    assert gap_words(contact)[0] == "wide"
    assert gap_words(contact)[2].endswith(" mm")
    trust = describe_trust(contact)
    assert "presses on itself at 1.27, 1.3" in trust
    assert "without friction" in trust


def test_derivatives_in_contact_agree_with_finite_differences(equilibria):
    """Along some directions: the whole energy, elastic and barrier."""
    here = equilibria[2]
    body, solver = here._shell.body(here.stretch), here._solver
    free = solver.assembly.free
    hessian = solver.configure(body, here.state).hessian()
    rng, step = np.random.default_rng(0), 2e-8
    for _ in range(3):
        way = np.zeros_like(here.state)
        way[free] = rng.normal(size=len(free))
        near, far = (
            [solver.configure(body, here.state + sign * size * way) for sign in (1, -1)]
            for size in (step, 2 * step)
        )
        change = 8 * (near[0].residual - near[1].residual) - (far[0].residual - far[1].residual)
        expected = hessian @ way[free]
        assert np.abs(change / (12 * step) - expected).max() < 1e-7 * np.abs(expected).max()
    barrier = body.contact.at(here.state)
    forces = barrier.gradient
    way = rng.normal(size=len(forces)) * (forces != 0)
    energies = [body.contact.at(here.state + s * step * way).energy for s in (1, -1, 2, -2)]
    slope = (8 * (energies[0] - energies[1]) - (energies[2] - energies[3])) / (12 * step)
    assert slope == pytest.approx(forces @ way, rel=1e-7)


def test_a_rigid_motion_changes_no_contact_energy(equilibria, mesh):
    here, count = equilibria[2], 3 * len(mesh.points)
    contact = here._shell.contact(here.stretch)
    moved = here.state.copy()
    turn = Rotation.from_rotvec([0.7, -1.9, 0.4])
    nodes = turn.apply(here.state[:count].reshape(-1, 3)) + np.array([3e-3, -2e-3, 1e-3])
    moved[:count] = nodes.reshape(-1)
    before, after = contact.at(here.state), contact.at(moved)
    assert before.energy > 0
    assert after.energy == pytest.approx(before.energy, rel=1e-9)
    turned = turn.apply(before.gradient[:count].reshape(-1, 3)).reshape(-1)
    scale = np.abs(turned).max()
    assert np.abs(after.gradient[:count] - turned).max() < 1e-9 * scale


def test_the_forces_of_the_held_nodes_are_free_of_contact(equilibria):
    """The barrier balances itself, so holding the sheet elsewhere changes nothing."""
    here = equilibria[2]
    forces = here._shell.contact(here.stretch).at(here.state).gradient
    nodes = forces[: 3 * len(here._shell.mesh.points)].reshape(-1, 3)
    assert np.abs(nodes.sum(axis=0)).max() < 1e-8 * np.abs(nodes).sum()


def test_a_path_goes_on_from_a_saved_contact(specimen, mesh, equilibria):
    again = open_path(specimen, MorleySettings(contact="barrier"), mesh=mesh)
    again.restore(equilibria[1].save())
    *_, found = again.approach(specimen.prestretch.milestones[2])
    assert np.array_equal(found.state, equilibria[2].state)


def test_the_tangent_has_the_barrier_in_it(equilibria):
    here = equilibria[2]
    side = np.random.default_rng(0).normal(size=here.state.size)
    side[here._shell.held] = 0.0
    hessian = here._solver.configure(here._shell.body(here.stretch), here.state).hessian()
    solved = here.linearised().solve(side)[here._solver.assembly.free]
    assert hessian @ solved == pytest.approx(side[here._solver.assembly.free], abs=1e-6)


def test_without_the_package_the_run_says_what_to_install(specimen, mesh, monkeypatch):
    monkeypatch.setitem(sys.modules, "ipctk", None)
    settings = MorleySettings(contact="barrier")
    result = solve(specimen.with_milestones([CROSSED]), "dshell", settings, mesh=mesh)
    assert touches_itself(result).all()
    assert "pip install 'bilayer-shells[contact]'" in describe_trust(result)
    assert "\n" not in describe_trust(result)


def test_damped_motion_does_not_model_contact():
    with pytest.raises(InputError, match=r"solver.contact = 'barrier': expected .* 'static'"):
        MorleySettings(contact="barrier", method="dynamic")


@needs_ipctk
def test_the_lattice_takes_contact_too(specimen, mesh):
    settings = HingeSettings(contact="barrier")
    result = solve(specimen.with_milestones([1.03]), "dshell", settings, mesh=mesh)
    assert result["converged"].values.all()
    assert (result["contact_crosses"].values == 0).all()


@needs_ipctk
def test_a_thin_substrate_is_pressed_onto_itself_between_thick_petals():
    """Stretched by three tenths, what is bare of it folds; the mesh is coarse for that."""
    example = Path(__file__).parents[2] / "examples" / "thin_substrate.toml"
    sheet = read_specimen(example, ["mesh.size=9 mm", "prestretch.milestones=[1.1, 1.3]"])
    result = solve(sheet, "dshell", MorleySettings(contact="barrier"))
    assert result["converged"].values.all()
    assert result["unstable_modes"].values.tolist() == [0, 0]
    assert result["contact_crosses"].values.tolist() == [0, 0]
    assert result["contact_pairs"].values[1] > 0
    assert result["height"].values[1] == pytest.approx(34e-3, rel=0.05)
