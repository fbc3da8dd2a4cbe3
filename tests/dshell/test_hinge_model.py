"""The mended hinges: laminate theory's rest state, what it gives, and what it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from verification import bilayers

from bilayer import InputError, Layer, LinearElastic, PlanarMesh, Prestretch, solve
from bilayer.mesh.generation import generate_mesh
from bilayer.specimen.two_layers import BARE, KIRIGAMI, LAYERS, disc_bilayer
from dshell import HingeSettings, MorleySettings
from dshell.energies.topology import Topology
from dshell.models.hinge_rest_state import (
    circumcentre_distances,
    laminate_springs_and_hinges,
    specimen_sections,
)

EDGE = 1e-3  # m


def equilateral(rows=12):
    """Equilateral triangles of edge EDGE in a parallelogram."""
    x, y = np.meshgrid(np.arange(rows), np.arange(rows), indexing="ij")
    points = EDGE * np.column_stack([(x + y / 2).ravel(), (y * np.sqrt(3) / 2).ravel()])
    number = np.arange(rows * rows).reshape(rows, rows)
    a, b = number[:-1, :-1].ravel(), number[1:, :-1].ravel()
    c, d = number[1:, 1:].ravel(), number[:-1, 1:].ravel()
    triangles = np.concatenate([np.column_stack([a, b, d]), np.column_stack([b, c, d])])
    return PlanarMesh(points, triangles, np.ones(len(triangles)))


def timoshenko(mismatch):
    """Curvature of two layers of one Poisson's ratio by Timoshenko (1925), 1/m."""
    n = bilayers.SUBSTRATE.material.young_modulus / bilayers.KIRIGAMI.material.young_modulus
    return 6 * mismatch * 4 / (2e-3 * (12 + (1 + n) * (1 + 1 / n)))


def test_section_has_timoshenkos_curvature():
    tiny = 1e-7
    _, bilayer = specimen_sections(bilayers.ladder_disc(), (1 + tiny, 1 + tiny))
    assert bilayer.curvature == pytest.approx(timoshenko(tiny), rel=1e-5)


def test_bare_substrate_shrinks_and_stays_flat():
    bare, _ = specimen_sections(bilayers.ladder_disc(), (1.1, 1.2))
    assert bare.strain == pytest.approx([1 / 1.1 - 1, 1 / 1.2 - 1])
    assert bare.curvature == pytest.approx([0, 0], abs=1e-12)
    assert bare.neutral_axis == pytest.approx(-1e-3 / 1.1 / 1.2 / 2)


def test_cutouts_have_the_natural_state_of_the_bare_substrate(coarse_specimen, coarse_mesh):
    """And the edges of the cuts that of both sides, by their areas and stiffnesses."""
    stretch = (1.2, 1.1)
    bare, bilayer = specimen_sections(coarse_specimen, stretch)
    springs, hinges = laminate_springs_and_hinges(coarse_mesh, bare, bilayer)
    topology = Topology.of(coarse_mesh.triangles)
    along = np.diff(coarse_mesh.points[topology.edges], axis=1)[:, 0][topology.hinge_edges]
    sides = coarse_mesh.region[topology.hinge_faces]
    natural = springs.natural_length[topology.hinge_edges]
    cut_out, covered = (np.all(sides == region, axis=1) for region in (BARE, KIRIGAMI))
    released = np.linalg.norm(along / stretch, axis=1)
    assert natural[cut_out] == pytest.approx(released[cut_out])
    assert hinges.natural_angle[cut_out] == pytest.approx(0, abs=1e-12)
    held = np.linalg.norm(along * (1 + bilayer.strain), axis=1)
    assert natural[covered] == pytest.approx(held[covered])
    at_cuts = ~cut_out & ~covered
    between = (natural - released)[at_cuts] / (held - released)[at_cuts]
    assert min(map(np.count_nonzero, (cut_out, covered, at_cuts))) > 10
    assert 0 < between.min() < between.max() < 1


@pytest.mark.parametrize("settings", [HingeSettings(), MorleySettings()], ids=["hinge", "morley"])
def test_a_free_layer_of_the_linear_law_shrinks_to_its_natural_state(settings, coarse_mesh):
    """sqrt(1 - 2 (l - 1)), 0.7746 at 1.2, where a hyperelastic law shrinks to 1 / l."""
    law = LinearElastic(116_250.0, 0.49)
    layers = (Layer(name, 1e-3, law) for name in LAYERS)
    specimen = disc_bilayer(0.04, *layers, Prestretch([1.2]), stretched=LAYERS)
    covered = PlanarMesh(
        coarse_mesh.points, coarse_mesh.triangles, np.ones_like(coarse_mesh.region)
    )
    result = solve(specimen, "dshell", settings, mesh=covered)
    span = result.span.values[0, :2] / np.ptp(covered.points, axis=0)
    assert span == pytest.approx([0.6**0.5] * 2, rel=1e-6)


def test_where_the_linear_law_has_no_natural_state_the_hinges_are_refused():
    law = LinearElastic(116_250.0, 0.49)
    specimen = bilayers.ladder_disc().with_layer("substrate", material=law)
    with pytest.raises(InputError, match="the linear law has no stress-free state"):
        specimen_sections(specimen, (1.5, 1.5))


def test_equilateral_lattice_has_the_closed_forms():
    """k_s = sqrt(3)/2 A a^2, k_b = 2/sqrt(3) D, theta = a (3 k_nn - k_tt) / (2 sqrt(3))."""
    mesh = equilateral()
    bare, bilayer = specimen_sections(bilayers.ladder_disc(), (1.03, 1.01))
    springs, hinges = laminate_springs_and_hinges(mesh, bare, bilayer)
    inner = Topology.of(mesh.triangles).hinge_edges
    assert springs.stiffness[inner] == pytest.approx(np.sqrt(3) / 2 * bilayer.stretching * EDGE**2)
    assert hinges.stiffness == pytest.approx(2 / np.sqrt(3) * bilayer.bending)
    along = np.diff(mesh.points[hinges.nodes[:, :2]], axis=1)[:, 0] / EDGE
    across = along[:, ::-1]
    k_tt, k_nn = along**2 @ bilayer.curvature, across**2 @ bilayer.curvature
    assert hinges.natural_angle == pytest.approx(EDGE * (3 * k_nn - k_tt) / (2 * np.sqrt(3)))


def test_circumcentres_of_equilateral_triangles():
    mesh = equilateral()
    distances = circumcentre_distances(mesh, Topology.of(mesh.triangles))
    assert distances == pytest.approx(EDGE / np.sqrt(3))


def released_curvature(mesh, stretch=1.0005):
    """2 x the least-squares coefficient of the released height over the radius, over laminate's."""
    specimen = bilayers.ladder_disc().with_milestones([stretch])
    result = solve(specimen, "dshell", HingeSettings(), mesh=mesh)
    x, y, z = result.position.values[0].T
    fit, *_ = np.linalg.lstsq(np.column_stack([np.ones_like(x), x, y, x**2 + y**2]), z, rcond=None)
    return -2 * fit[3] / specimen_sections(specimen, (stretch, stretch))[1].curvature[0]


@pytest.mark.parametrize("size", [0.008, 0.004])
def test_uniform_disc_has_the_laminates_curvature_whatever_the_mesh(size):
    mesh = generate_mesh(bilayers.ladder_disc(size=size))
    assert released_curvature(mesh) == pytest.approx(1.0, abs=0.02)


def test_result_lists_stretching_and_bending(coarse_specimen, coarse_mesh):
    specimen = replace(coarse_specimen).with_milestones([1.03, 1.06])
    result = solve(specimen, "dshell", HingeSettings(), mesh=coarse_mesh)
    assert set(result.term.values) == {"stretching", "bending"}
    assert result.converged.values.tolist() == [1, 1]
    assert result.attrs["model"] == "hinge"
