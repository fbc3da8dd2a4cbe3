"""The verification ladder for the Morley shell; the numbers were computed elsewhere."""

from dataclasses import replace

import numpy as np
import pytest
import shell_cases as cases

from bilayer import CutPattern, MeshSize, PlanarMesh, generate_mesh, solve
from dshell import MorleySettings

GRID = np.linspace(-0.02, 0.02, 13)  # m


@pytest.mark.parametrize(
    "mesh",
    [
        cases.rectangle(GRID, GRID),
        cases.rectangle(GRID, GRID, jitter=0.25),
        generate_mesh(cases.ladder_disc()),
    ],
    ids=["right", "jittered", "unstructured"],
)
def test_small_mismatch_gives_laminate_theorys_curvature_in_every_face(mesh):
    assert cases.small_mismatch_curvature(mesh) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize(
    ("mismatch", "sag", "centre"),
    [(0.2, 0.19407, 0.19092), (0.5, 0.43398, 0.40071), (1.0, 0.71125, 0.57980)],
)
def test_cap_of_a_uniform_disc(mismatch, sag, centre):
    """Rung 6: the von Karman solution."""
    cap = cases.scaled_cap(mismatch)
    assert cap.sag == pytest.approx(sag, rel=0.01)
    assert cap.centre == pytest.approx(centre, rel=0.01)


@pytest.mark.parametrize(("share", "is_round"), [(0.98, True), (1.02, False)])
def test_uniform_disc_loses_its_symmetry(share, is_round):
    """Rung 7: at S = 1.15075; the static solver leaves the unstable cap by itself."""
    specimen = cases.ladder_disc().with_milestones([cases.stretch_of(share * 1.15075)])
    result = solve(specimen, "dshell", MorleySettings())
    x, y, _ = result.span.values[0]
    assert result.unstable_modes.values.tolist() == [0]
    assert (abs(x / y - 1) < 2e-3) == is_round


def test_supported_plate_converges_at_second_order():
    """Rung 13: 0.00406235 q a^4 / D (Timoshenko and Woinowsky-Krieger, table 8)."""
    errors = [cases.supported_plate(cells) / 0.00406235 - 1 for cells in (10, 20, 50)]
    rates = np.log(np.divide(errors[:-1], errors[1:])) / np.log([2, 2.5])
    assert rates == pytest.approx([2, 2], abs=0.1)
    assert abs(errors[-1]) < 3e-3  # 5000 triangles


@pytest.mark.parametrize(("load", "drop"), [(1, 0.123471), (5, 0.495905), (10, 0.700200)])
def test_heavy_cantilever(load, drop):
    """Rung 11: the elastica under b = q L^3 / EI."""
    length, thickness, young = 0.1, 1e-3, 1e6
    weight = load * young * thickness**3 / 12 / length**3
    line = cases.cantilever(length, 0.01, thickness, young, weight)
    assert (line[0, 2] - line[-1, 2]) / length == pytest.approx(drop, rel=0.01)


def test_a_strip_of_constant_natural_curvature_rolls_to_a_full_circle():
    """Rung 10: u / L = sin(f) / f - 1, w / L = (1 - cos f) / f; like layers: k = 3/2 e / t."""
    length, thickness = 0.1, 1e-3
    for turn in (np.pi / 2, 2 * np.pi):
        full = turn / length * thickness / 1.5
        line = cases.cantilever(length, 0.01, thickness, 1e6, mismatches=full * np.arange(1, 7) / 6)
        end = line[-1] / np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
        assert end[0] == pytest.approx(np.sin(turn) / turn, abs=5e-3)
        assert -end[2] == pytest.approx((1 - np.cos(turn)) / turn, abs=5e-3)


def test_timoshenko_strip():
    """Rung 4."""
    assert cases.timoshenko_strip(1.01) == pytest.approx(6.793, rel=0.01)


def test_petals_are_alike_on_an_unsymmetric_mesh():
    specimen = cases.ladder_disc(CutPattern(5, 0.008, 0.3), 0.003).with_milestones([1.06, 1.15])
    mesh = generate_mesh(specimen)
    result = solve(specimen, "dshell", MorleySettings(), mesh=mesh)
    for shape in result.position.values:
        radii = cases.petal_radii(specimen, mesh, shape)
        assert radii == pytest.approx(radii.mean(), rel=3e-3)


def test_equal_prestretch_of_both_layers_stays_flat_and_shrinks(coarse_mesh):
    layers = [
        replace(layer, prestretch=1.2 * np.eye(2))
        for layer in cases.specimen_layers(cases.ladder_disc(), coarse_mesh, (1.2, 1.2))
    ]
    covered = np.full(len(coarse_mesh.triangles), 1)
    mesh = PlanarMesh(coarse_mesh.points, coarse_mesh.triangles, covered)
    layers[1] = replace(layers[1], faces=None)
    faces, flat = cases.plate(mesh, layers)
    held = cases.held_coordinates(mesh)
    state = cases.Problem(faces, flat, held, np.zeros(len(flat))).solved()
    nodes = state[: 3 * len(mesh.points)].reshape(-1, 3)
    flat_nodes = flat[: 3 * len(mesh.points)].reshape(-1, 3)
    assert np.abs(nodes[:, 2]).max() < 1e-7
    apart = np.linalg.norm(nodes - nodes[mesh.centre_node], axis=1)
    before = np.linalg.norm(flat_nodes - flat_nodes[mesh.centre_node], axis=1)
    assert apart == pytest.approx(before / 1.2, abs=1e-9)


def test_two_like_layers_are_one_plate_of_twice_the_thickness(coarse_mesh):
    rng = np.random.default_rng(6)
    one = cases.single_layer(1e5, 0.4, 2e-3)
    two = [replace(one, top=0.0), replace(one, bottom=0.0)]
    single, flat = cases.plate(coarse_mesh, [one])
    double, _ = cases.plate(coarse_mesh, two)
    values = (flat + rng.uniform(-5e-4, 5e-4, flat.shape))[single.dofs]
    assert double.energy(values) == pytest.approx(single.energy(values), rel=1e-12)
    assert np.allclose(double.gradient(values), single.gradient(values), rtol=1e-10, atol=1e-12)


@pytest.fixture(scope="module")
def gentle(coarse_specimen):
    return coarse_specimen.with_milestones([1.06])


@pytest.fixture(scope="module")
def released(gentle, coarse_mesh):
    return solve(gentle, "dshell", MorleySettings(tolerance=1e-11), mesh=coarse_mesh)


def test_mirrored_mesh_gives_the_mirrored_shape(released, gentle, coarse_mesh):
    flip = np.array([1, -1, 1])
    mirrored = PlanarMesh(
        coarse_mesh.points * flip[:2], coarse_mesh.triangles[:, ::-1], coarse_mesh.region
    )
    again = solve(gentle, "dshell", MorleySettings(tolerance=1e-11), mesh=mirrored)
    assert again.position.values[0] == pytest.approx(released.position.values[0] * flip, abs=1e-8)


def test_numbering_does_not_matter(released, gentle, coarse_mesh):
    rng = np.random.default_rng(5)
    order, faces = (rng.permutation(len(a)) for a in (coarse_mesh.points, coarse_mesh.triangles))
    triangles = np.roll(np.argsort(order)[coarse_mesh.triangles[faces]], 1, axis=1)
    mesh = PlanarMesh(coarse_mesh.points[order], triangles, coarse_mesh.region[faces])
    again = solve(gentle, "dshell", MorleySettings(tolerance=1e-11), mesh=mesh)
    assert again.position.values[0] == pytest.approx(released.position.values[0, order], abs=1e-8)


def test_a_prestretch_along_one_axis_bends_about_the_other(coarse_mesh):
    specimen = replace(cases.ladder_disc(), mesh=MeshSize(0.01)).with_milestones([(1.02, 1.0)])
    result = solve(specimen, "dshell", MorleySettings())
    x, y, _ = np.ptp(result.position.values[0], axis=0)
    assert x < 0.97 * y
