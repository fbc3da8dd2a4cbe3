"""The solid of either orientation and with either layer stretched: turned over, flat, bent."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from bilayer import MeshSize, PlanarMesh, generate_mesh, paper_specimen, solve
from bilayer.exports.conversion import convert
from bilayer.geometry.alignment import rms_distance
from bilayer.mesh.planar import flat_surface
from bilayer.specimen.two_layers import with_stretched

COARSE = replace(paper_specimen(), mesh=MeshSize(0.016))
STRETCH = (1.03, 1.02)
RADIUS = COARSE.characteristic_length


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(COARSE)


def released(mesh, layers, side, stretch=STRETCH):
    specimen = with_stretched(COARSE, layers).with_milestones([stretch])
    if side == "below":
        specimen = replace(specimen, layers=specimen.layers[::-1])
    return solve(specimen, "fenics", mesh=mesh, start="flat")


def turned_over(mesh):
    """The mesh turned by half a turn about x, seen from what was its lower side.

    Its nodes are numbered in the opposite order: so the prisms over it are cut into tetrahedra as
    those under the original are, see `fenics_model.mesh.volume_mesh`.
    """
    last = len(mesh.points) - 1
    return PlanarMesh(mesh.points[::-1] * [1, -1], last - mesh.triangles[:, ::-1], mesh.region)


@pytest.fixture(scope="module")
def inner_kirigami(mesh):
    return released(mesh, ("kirigami",), "below")


def test_turned_over_it_is_the_same_body(mesh, inner_kirigami):
    above = released(turned_over(mesh), ("kirigami",), "above")
    position = above.position.values[0, ::-1] * [1, -1, -1]
    below = inner_kirigami
    weights = flat_surface(mesh).node_areas
    assert rms_distance(below.position.values[0], position, weights) < 1e-7 * RADIUS
    for name in ("quality", "sphere_radius", "height"):
        assert below[name].values == pytest.approx(above[name].values, rel=1e-6)
    assert below.energy.sel(term="kirigami").values == pytest.approx(
        above.energy.sel(term="kirigami").values, rel=1e-6
    )


def test_the_stretched_layer_is_the_inner_side(mesh, inner_kirigami):
    """It shrinks, so the dome opens to its side: downward here, upward where it lies above."""
    upward = released(mesh, ("kirigami",), "above")
    for result, sign in ((inner_kirigami, 1), (upward, -1)):
        height = result.position.values[0, :, 2]
        assert sign * (height[mesh.centre_node] - height[mesh.rim_nodes].mean()) > 2e-3
        assert result.unstable_modes.values.tolist() == [0]


@pytest.mark.parametrize("side", ["above", "below"])
def test_both_layers_stretched_alike_stay_flat_and_shrink(mesh, side):
    result = released(mesh, ("substrate", "kirigami"), side)
    shrunk = np.pad(mesh.points / STRETCH, ((0, 0), (0, 1)))
    weights = flat_surface(mesh).node_areas
    assert rms_distance(result.position.values[0], shrunk, weights) < 1e-9 * RADIUS
    assert np.abs(result.energy.values).max() < 1e-15  # J


def test_layers_without_prestretch_stay_flat(mesh):
    result = released(mesh, ("kirigami",), "below", (1.0, 1.0))
    assert np.ptp(result.position.values[0, :, 2]) < 1e-9 * RADIUS


def test_the_volume_lies_where_its_layer_does(mesh, inner_kirigami, tmp_path):
    corners = inner_kirigami.volume_reference_position.values[inner_kirigami.volume_cells.values]
    below = corners[:, :, 2].mean(axis=1) < 0
    assert inner_kirigami["layer"].attrs["flag_meanings"] == "substrate kirigami"
    assert np.array_equal(inner_kirigami["layer"].values, below)
    convert(inner_kirigami, tmp_path / "solid.vtu", part="volume")
