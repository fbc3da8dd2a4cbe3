"""A fine mesh that starts from a coarse one's shape ends where it would from flat."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import InputError, MeshSize, generate_mesh, solve
from bilayer.errors import ComputationError
from dshell import HingeSettings, MorleySettings, solver
from dshell.release import coarse_start
from dshell.release.coarse_start import coarse_mesh, prolonged
from dshell.release.specimen_path import ShellPath

COARSE = 120
KINDS = pytest.mark.parametrize("kind", [MorleySettings, HingeSettings])


@pytest.fixture(scope="module")
def fine_specimen(coarse_specimen):
    return replace(coarse_specimen, mesh=MeshSize(0.0045)).with_milestones([1.06])


@pytest.fixture(scope="module")
def fine_mesh(fine_specimen):
    return generate_mesh(fine_specimen)


@KINDS
def test_it_ends_in_the_equilibrium_that_flat_leads_to(kind, fine_specimen, fine_mesh):
    from_flat, from_coarse = (
        solve(fine_specimen, "dshell", kind(coarse_triangles=count), mesh=fine_mesh)
        for count in (0, COARSE)
    )
    assert from_flat.attrs["start"] == "flat"
    assert from_coarse.attrs["start"].startswith("flat, on a coarse mesh first: dshell, model")
    assert from_coarse.iterations.values[0] < 0.7 * from_flat.iterations.values[0]
    assert from_coarse.load_steps.values.tolist() == [1]
    assert from_coarse.height.values == pytest.approx(from_flat.height.values, rel=1e-6)
    assert from_coarse.position.values == pytest.approx(from_flat.position.values, abs=1e-7)


def test_later_milestones_start_from_the_first(fine_specimen, fine_mesh):
    settings = MorleySettings(coarse_triangles=COARSE)
    both = fine_specimen.with_milestones([1.03, 1.06])
    result = solve(both, "dshell", settings, mesh=fine_mesh)
    single = solve(fine_specimen, "dshell", settings, mesh=fine_mesh)
    assert result.position.values[1] == pytest.approx(single.position.values[0], abs=1e-7)


def test_a_start_that_leads_nowhere_is_left_for_flat(fine_specimen, fine_mesh, monkeypatch):
    noise = np.random.default_rng(0).normal(scale=0.02, size=(len(fine_mesh.points), 3))
    monkeypatch.setattr(solver, "prolonged", lambda shape, coarse, fine: noise)
    settings = MorleySettings(coarse_triangles=COARSE)
    result = solve(fine_specimen, "dshell", settings, mesh=fine_mesh)
    flat = solve(fine_specimen, "dshell", MorleySettings(coarse_triangles=0), mesh=fine_mesh)
    assert result.converged.all()
    assert result.attrs["start"].startswith("flat, because what was to start it led nowhere: flat,")
    assert result.height.values == pytest.approx(flat.height.values, rel=1e-6)


def test_a_coarse_one_is_drawn_for_a_fine_one_alone(fine_specimen, fine_mesh, monkeypatch):
    coarse = coarse_mesh(fine_specimen, fine_mesh, COARSE)
    assert 0.5 * COARSE < len(coarse.triangles) < 2 * COARSE
    assert coarse_mesh(fine_specimen, fine_mesh, 0) is None
    assert coarse_mesh(fine_specimen, fine_mesh, len(fine_mesh.triangles) // 3) is None

    def fails(specimen):
        raise ComputationError("no gmsh")

    monkeypatch.setattr(coarse_start, "generate_mesh", fails)
    assert coarse_mesh(fine_specimen, fine_mesh, COARSE) is None


def turned(mesh, angle):
    c, s = np.cos(angle), np.sin(angle)
    return replace(mesh, points=mesh.points @ np.array([[c, s], [-s, c]]))


@pytest.mark.parametrize("angle", [0.0, 2 * np.pi / 5])
def test_a_mesh_turned_into_itself_has_the_same_cut(fine_specimen, fine_mesh, angle):
    assert coarse_mesh(fine_specimen, turned(fine_mesh, angle), COARSE) is not None


def test_a_mesh_with_another_cut_starts_from_flat(fine_specimen, fine_mesh):
    """Its coarse mesh would have the specimen's cut, and so another shape."""
    uncut = fine_specimen.with_layer("kirigami", pattern=None)
    assert coarse_mesh(fine_specimen, turned(fine_mesh, np.pi / 5), COARSE) is None
    assert coarse_mesh(uncut, fine_mesh, COARSE) is None
    result = solve(uncut, "dshell", MorleySettings(coarse_triangles=COARSE), mesh=fine_mesh)
    assert result.attrs["start"] == "flat"


def test_a_coarse_mesh_without_an_equilibrium_is_told(fine_specimen, fine_mesh, monkeypatch):
    follow = ShellPath.approach

    def approach(path, target):
        if len(path.mesh.triangles) < len(fine_mesh.triangles):
            raise ComputationError("lost")
        yield from follow(path, target)

    monkeypatch.setattr(ShellPath, "approach", approach)
    settings = MorleySettings(coarse_triangles=COARSE)
    result = solve(fine_specimen, "dshell", settings, mesh=fine_mesh)
    assert result.converged.all()
    assert result.attrs["start"].startswith("flat, because on a coarse mesh it stopped at prestr")


def test_a_flat_disc_is_prolonged_exactly(coarse_mesh, fine_mesh):
    stretched = np.array([[1.1, 0.2, 0.3], [-0.1, 0.9, 0.4]])
    found = prolonged(coarse_mesh.points @ stretched, coarse_mesh, fine_mesh)
    expected = fine_mesh.points @ stretched
    assert found == pytest.approx(expected, abs=1e-8)  # its slopes are found by iteration


def test_a_sphere_stays_one(coarse_mesh, fine_mesh):
    x, y = coarse_mesh.points.T
    sphere = np.column_stack([x, y, np.sqrt(0.06**2 - x**2 - y**2)])
    radii = np.linalg.norm(prolonged(sphere, coarse_mesh, fine_mesh), axis=1)
    assert np.ptp(radii) < 0.01 * radii.mean()  # linear interpolation: 0.03
    assert radii.mean() == pytest.approx(0.06, rel=0.05)


def test_a_bad_number_is_named():
    with pytest.raises(InputError, match=r"solver\.coarse_triangles = -1: expected"):
        MorleySettings(coarse_triangles=-1)
