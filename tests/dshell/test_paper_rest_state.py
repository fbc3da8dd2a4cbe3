"""The printed stiffnesses and rest state, and how far they are from laminate theory."""

from dataclasses import replace

import numpy as np
import pytest

from bilayer import PlanarMesh, paper_specimen
from bilayer.specimen.two_layers import KIRIGAMI
from dshell.energies.hinges import hinge_angles
from dshell.models.paper_rest_state import (
    edge_stiffness,
    effective_inertia,
    hinge_stiffness,
    natural_angle,
    rest_state,
)

SUBSTRATE, KIRIGAMI_MODULUS, THICKNESS = 116_250.0, 368_988.0, 1e-3


def timoshenko_curvature(mismatch):
    """Curvature of the paper's two layers by Timoshenko (1925), 1/m: m = t1/t2, n = E1/E2."""
    m, n = 1.0, SUBSTRATE / KIRIGAMI_MODULUS
    height = 2 * THICKNESS
    return 6 * mismatch * (1 + m) ** 2 / (
        height * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n)))
    )  # fmt: skip


def printed_curvature(stretch):
    """Curvature that the printed natural angle stands for, 1/m: sqrt(3) theta_bar / edge."""
    edge = 4e-3
    stretching = edge_stiffness(SUBSTRATE, THICKNESS, np.array([edge]))
    bending = hinge_stiffness(paper_specimen(), THICKNESS)
    return np.sqrt(3) * natural_angle(stretching, bending, stretch)[0] / edge


def test_inertia_of_two_equal_layers_is_that_of_one_beam():
    assert effective_inertia(0.3, 0.3, 1.0) == pytest.approx(0.6**3 / 12)
    assert effective_inertia(0.5, 0.1, 1.0) == pytest.approx(0.6**3 / 12)


def test_inertia_of_a_layer_on_a_soft_one_is_its_own():
    assert effective_inertia(0.3, 0.2, 1e-12) == pytest.approx(0.2**3 / 12)


def test_inertia_is_the_bending_stiffness_of_timoshenkos_beam():
    """E1 I1 + E2 I2 + (E1 A1 E2 A2 / (E1 A1 + E2 A2)) (distance of centres)^2."""
    h1, h2, n = 0.7, 1.1, 0.4
    expected = n * h1**3 / 12 + h2**3 / 12 + n * h1 * h2 / (n * h1 + h2) * ((h1 + h2) / 2) ** 2
    assert effective_inertia(h1, h2, n) == pytest.approx(expected)


def test_printed_curvature_is_twice_too_large():
    assert printed_curvature(1.06) == pytest.approx(1.425e3 * 0.06, rel=1e-3)
    assert timoshenko_curvature(1 - 1 / 1.06) == pytest.approx(0.686e3 * (1 - 1 / 1.06), rel=1e-3)
    assert printed_curvature(1.0001) / timoshenko_curvature(1e-4) == pytest.approx(2.08, rel=1e-2)


def test_angle_loses_the_sign_of_the_mismatch():
    assert printed_curvature(0.9) == pytest.approx(printed_curvature(1.1))


@pytest.fixture(scope="module")
def ramp(coarse_specimen, coarse_mesh):
    return rest_state(coarse_specimen, coarse_mesh, (1.2, 1.2))


def test_ramp_starts_at_the_flat_mesh_without_energy(ramp, coarse_mesh):
    springs, hinges = ramp.at(0.0)
    flat = np.column_stack([coarse_mesh.points, np.zeros(len(coarse_mesh.points))])
    assert springs.at(flat.reshape(-1)).energy() == pytest.approx(0.0, abs=1e-25)
    assert hinges.at(flat.reshape(-1)).energy() == pytest.approx(0.0, abs=1e-25)


def test_ramp_ends_at_the_printed_rest_state_and_is_linear(ramp, coarse_specimen):
    springs, hinges = ramp.at(1.0)
    assert springs.natural_length == pytest.approx(ramp.flat_length / 1.2)
    substrate = coarse_specimen.bonded_layer("substrate", (1.2, 1.2))
    stretching = np.sqrt(3) / 2 * SUBSTRATE * substrate.thickness
    assert springs.stiffness == pytest.approx(stretching * ramp.flat_length**2)
    halfway_springs, halfway_hinges = ramp.at(0.5)
    assert halfway_springs.natural_length == pytest.approx(ramp.flat_length * (1 + 1 / 1.2) / 2)
    assert halfway_hinges.natural_angle == pytest.approx(hinges.natural_angle / 2)


def test_natural_angle_equates_the_energies_hinge_by_hinge(ramp, coarse_mesh):
    """Eqs. 1 and 6: k_b theta_bar^2 / 2 = k_s (lambda - 1)^2 / 2, k_s of the hinge's own edge."""
    springs, hinges = ramp.at(1.0)
    energy_of_edge = dict(
        zip(map(tuple, springs.nodes), 0.5 * springs.stiffness * 0.2**2, strict=True)
    )
    expected = [energy_of_edge[tuple(sorted(nodes[:2]))] for nodes in hinges.nodes]
    assert 0.5 * hinges.stiffness * hinges.natural_angle**2 == pytest.approx(np.array(expected))


def test_only_hinges_within_the_bilayer_bend(ramp, coarse_mesh):
    sides = {}
    for triangle, region in zip(coarse_mesh.triangles, coarse_mesh.region, strict=True):
        for start, end in zip(triangle, np.roll(triangle, -1), strict=True):
            sides.setdefault(frozenset((start, end)), []).append(region)
    expected = {edge for edge, regions in sides.items() if regions == [KIRIGAMI, KIRIGAMI]}
    assert {frozenset(nodes[:2]) for nodes in ramp.hinges.nodes} == expected
    assert 0 < len(expected) < len(sides)


def test_natural_angles_make_a_dome_with_the_kirigami_outside(ramp, coarse_mesh):
    x, y = coarse_mesh.points.T
    dome = np.column_stack([x, y, -10 * (x**2 + y**2)])  # apex up, kirigami on the upper side
    assert np.all(hinge_angles(dome[ramp.hinges.nodes]) > 0)
    assert np.all(ramp.hinges.natural_angle > 0)


def test_thickness_rules_differ_by_the_area_stretch(coarse_specimen, coarse_mesh):
    def stiffness(rule):
        ruled = replace(
            coarse_specimen, prestretch=replace(coarse_specimen.prestretch, thickness=rule)
        )
        return rest_state(ruled, coarse_mesh, (1.1, 1.2)).springs.stiffness

    assert stiffness("constant") == pytest.approx(1.1 * 1.2 * stiffness("natural"))


def test_a_stretch_along_one_axis_shortens_edges_along_it_alone(coarse_specimen):
    square = PlanarMesh([[0, 0], [1, 0], [1, 1], [0, 1]], [[0, 1, 2], [0, 2, 3]], [1, 1])
    ramp = rest_state(coarse_specimen, square, (1.25, 1.0))
    lengths = dict(zip(map(tuple, ramp.springs.nodes), ramp.springs.natural_length, strict=True))
    assert lengths[0, 1] == pytest.approx(0.8)
    assert lengths[0, 3] == pytest.approx(1.0)
    assert lengths[0, 2] == pytest.approx(np.hypot(0.8, 1.0))
