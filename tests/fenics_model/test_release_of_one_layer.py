"""A layer alone, prestretched and freed, is stress-free and shrunk by exactly 1 / lambda."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.solid_problem import (
    equilibria,
    load_path,
    mean,
    newton_of,
    rectangle,
    solid_of,
    stacked,
    stress,
)

from bilayer import LinearElastic, MooneyRivlin
from bilayer.geometry.alignment import align
from bilayer.specimen.layer import Response
from bilayer.specimen.support import choose_nodes_inside
from fenics_model.path.load_schedule import LoadSchedule
from fenics_model.release.specimen_solid import held_points, natural_state

SIDE, THICKNESS = 4e-2, 1e-3
LAWS = [MooneyRivlin(4839.1, 14536.0, 1e-6), MooneyRivlin(4839.1, 14536.0)]


@pytest.mark.mpi
@pytest.mark.parametrize("law", LAWS, ids=["compressible", "incompressible"])
@pytest.mark.parametrize("stretch", [(1.2, 1.2), (1.3, 1.1)], ids=["equibiaxial", "anisotropic"])
@pytest.mark.parametrize("angle", [0.0, 0.4], ids=["along x and y", "turned"])
@pytest.mark.parametrize("rule", ["natural", "constant"])
def test_free_release(law, stretch, angle, rule):
    mesh = rectangle(SIDE, SIDE, 4, 4)
    volume = stacked(mesh, [THICKNESS])
    solid = solid_of(volume, [law])
    held = solid.held_points(held_points(choose_nodes_inside(mesh.points), volume))
    path, response = LoadSchedule([(1.1, 1.05), stretch]), Response("path", angle=angle)

    def load(parameter):
        tensor = response.tensor(path.stretch(parameter))
        solid.layers[0].natural.value = natural_state(tensor, rule)

    with newton_of(solid, held) as newton:
        _, released = equilibria(load_path(newton, load, 0.02, tolerance=1e-12), path.milestones)
    in_plane = volume.points[:, :2] @ np.linalg.inv(response.tensor(stretch))
    across = volume.points[:, 2] / natural_state(response.tensor(stretch), rule)[3]
    moved = solid.vertex_positions(released.state)
    at_rest = align(moved, np.column_stack([in_plane, across]), np.ones(len(moved)))
    assert np.abs(at_rest - np.column_stack([in_plane, across])).max() < 1e-8 * SIDE
    prestress = law.young_modulus * (stretch[0] - 1)
    for i, j in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2)]:
        assert abs(mean(solid, released.state, stress(solid)[i, j])) < 1e-8 * prestress


def test_the_held_points_of_a_free_body_carry_nothing():
    """Six statically determinate constraints: their reactions vanish, and with them any strain."""
    mesh = rectangle(SIDE, SIDE / 2, 4, 2)
    volume = stacked(mesh, [THICKNESS, THICKNESS])
    solid = solid_of(volume, [LinearElastic(1e5, 0.4), LinearElastic(3e5, 0.4)])
    held = solid.held_points(held_points(choose_nodes_inside(mesh.points), volume))
    solid.layers[0].natural.value = (1.002, 0.0, 1.002, 1.0)
    with newton_of(solid, held) as newton:
        outcome = newton.solve(solid.undeformed, 1e-11)
    assert outcome.converged
    assert np.ptp(solid.vertex_displacements(outcome.state)[:, 2]) > 1e-4  # it did bend
    with newton_of(solid, []) as free:
        assert free.residual_norm(outcome.state) < 1e-10
