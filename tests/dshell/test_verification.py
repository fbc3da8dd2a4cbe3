"""The verification ladder of the shells, and what else must hold for any bilayer."""

from dataclasses import replace

import numpy as np
import pytest
from verification import bilayers, meshes, shell_problem
from verification.rung import MISSED
from verification.shell_rungs import TESTED_RUNGS

from bilayer import CutPattern, MeshSize, PlanarMesh, generate_mesh, solve
from dshell import HingeSettings, MorleySettings
from dshell.models.hinge_rest_state import specimen_sections
from dshell.models.morley import specimen_layers
from dshell.release.rigid_motion import choose_far_nodes, held_coordinates

GRID = np.linspace(-0.02, 0.02, 13)  # m


@pytest.mark.parametrize(
    "mesh",
    [
        meshes.rectangle(GRID, GRID),
        meshes.rectangle(GRID, GRID, jitter=0.25),
        generate_mesh(bilayers.ladder_disc()),
    ],
    ids=["right", "jittered", "unstructured"],
)
def test_small_mismatch_gives_laminate_theorys_curvature_in_every_face(mesh):
    assert bilayers.small_mismatch_curvature(mesh) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("rung", TESTED_RUNGS, ids=lambda rung: f"{rung.number} {rung.title}")
def test_rung(rung):
    """The rungs that `scripts/verify` computes."""
    checks = rung.climb()
    assert any(check.tolerance is not None for check in checks)
    assert [check for check in checks if check.verdict == MISSED] == []


def test_petals_are_alike_on_an_unsymmetric_mesh():
    specimen = bilayers.ladder_disc(CutPattern(5, 0.008, 0.3), 0.003).with_milestones([1.06, 1.15])
    mesh = generate_mesh(specimen)
    result = solve(specimen, "dshell", MorleySettings(), mesh=mesh)
    for shape in result.position.values:
        radii = bilayers.petal_radii(specimen, mesh, shape)
        assert radii == pytest.approx(radii.mean(), rel=3e-3)


def test_equal_prestretch_of_both_layers_stays_flat_and_shrinks(coarse_mesh):
    layers = [
        replace(layer, prestretch=1.2 * np.eye(2))
        for layer in specimen_layers(bilayers.ladder_disc(), coarse_mesh, (1.2, 1.2))
    ]
    covered = np.full(len(coarse_mesh.triangles), 1)
    mesh = PlanarMesh(coarse_mesh.points, coarse_mesh.triangles, covered)
    layers[1] = replace(layers[1], faces=None)
    faces, flat = shell_problem.plate(mesh, layers)
    held = held_coordinates(choose_far_nodes(mesh))
    state = shell_problem.Problem(faces, flat, held, np.zeros(len(flat))).solved()
    nodes = state[: 3 * len(mesh.points)].reshape(-1, 3)
    flat_nodes = flat[: 3 * len(mesh.points)].reshape(-1, 3)
    assert np.abs(nodes[:, 2]).max() < 1e-7
    apart = np.linalg.norm(nodes - nodes[mesh.centre_node], axis=1)
    before = np.linalg.norm(flat_nodes - flat_nodes[mesh.centre_node], axis=1)
    assert apart == pytest.approx(before / 1.2, abs=1e-9)


def test_two_like_layers_are_one_plate_of_twice_the_thickness(coarse_mesh):
    rng = np.random.default_rng(6)
    one = shell_problem.single_layer(1e5, 0.4, 2e-3)
    two = [replace(one, top=0.0), replace(one, bottom=0.0)]
    single, flat = shell_problem.plate(coarse_mesh, [one])
    double, _ = shell_problem.plate(coarse_mesh, two)
    values = flat + rng.uniform(-5e-4, 5e-4, flat.shape)
    bent, expected = double.at(values), single.at(values)
    assert bent.energy() == pytest.approx(expected.energy(), rel=1e-12)
    assert np.allclose(bent.gradient(), expected.gradient(), rtol=1e-10, atol=1e-12)


def test_two_like_layers_have_the_section_of_one_of_twice_the_thickness():
    substrate = bilayers.SUBSTRATE
    like = bilayers.ladder_disc().with_layer("kirigami", material=substrate.material)
    _, double = specimen_sections(like, (1.0, 1.0))
    thick = like.with_layer("substrate", thickness=2 * substrate.thickness)
    single, _ = specimen_sections(thick, (1.0, 1.0))
    assert double.stretching == pytest.approx(single.stretching)
    assert double.bending == pytest.approx(single.bending)
    assert double.curvature == pytest.approx([0, 0], abs=1e-12)


@pytest.fixture(scope="module")
def gentle(coarse_specimen):
    return coarse_specimen.with_milestones([1.06])


@pytest.fixture(scope="module", params=[MorleySettings, HingeSettings], ids=["morley", "hinge"])
def settings(request):
    return request.param(tolerance=1e-11)


@pytest.fixture(scope="module")
def released(gentle, coarse_mesh, settings):
    return solve(gentle, "dshell", settings, mesh=coarse_mesh)


def test_mirrored_mesh_gives_the_mirrored_shape(released, gentle, coarse_mesh, settings):
    flip = np.array([1, -1, 1])
    mirrored = PlanarMesh(
        coarse_mesh.points * flip[:2], coarse_mesh.triangles[:, ::-1], coarse_mesh.region
    )
    again = solve(gentle, "dshell", settings, mesh=mirrored)
    assert again.position.values[0] == pytest.approx(released.position.values[0] * flip, abs=1e-8)


def test_numbering_does_not_matter(released, gentle, coarse_mesh, settings):
    rng = np.random.default_rng(5)
    order, faces = (rng.permutation(len(a)) for a in (coarse_mesh.points, coarse_mesh.triangles))
    triangles = np.roll(np.argsort(order)[coarse_mesh.triangles[faces]], 1, axis=1)
    mesh = PlanarMesh(coarse_mesh.points[order], triangles, coarse_mesh.region[faces])
    again = solve(gentle, "dshell", settings, mesh=mesh)
    assert again.position.values[0] == pytest.approx(released.position.values[0, order], abs=1e-8)


def test_a_prestretch_along_one_axis_bends_about_the_other(coarse_mesh):
    specimen = replace(bilayers.ladder_disc(), mesh=MeshSize(0.01)).with_milestones([(1.02, 1.0)])
    result = solve(specimen, "dshell", MorleySettings())
    x, y, _ = np.ptp(result.position.values[0], axis=0)
    assert x < 0.97 * y
