"""The skin as a function of a surface: its points and their derivatives."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import diags
from scipy.spatial.transform import Rotation
from verification.derivatives import derivative_by_points

from bilayer import MeshSize, generate_mesh, paper_specimen
from bilayer.contact.skin import BondedBody, skin_of
from bilayer.contact.skin_map import SkinMap
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import flat_surface

STEP = 1e-6


@pytest.fixture(scope="module")
def body():
    specimen = replace(paper_specimen(), mesh=MeshSize(0.014))
    return BondedBody.of(specimen, generate_mesh(specimen), (1.1, 1.05))


@pytest.fixture(scope="module")
def dome(body):
    """Return a rough dome, (n, 3), m."""
    x, y = body.mesh.points.T
    rough = np.random.default_rng(0).uniform(-3e-4, 3e-4, (len(x), 3))
    return np.column_stack([0.97 * x, 0.98 * y, -8 * (x**2 + y**2)]) + rough


class Quadratic:
    """A function of the skin's points: its value and derivatives."""

    def __init__(self, skin):
        rng = np.random.default_rng(1)
        self._linear = rng.normal(size=(len(skin.node), 3))
        self._square = 100 * rng.normal(size=3 * len(skin.node))

    def gradient(self, points):
        return self._linear + (self._square * points.reshape(-1)).reshape(-1, 3)

    def value(self, points):
        return float((self._linear * points).sum() + self._square @ points.reshape(-1) ** 2 / 2)

    def hessian(self):
        return diags(self._square).tocsr()


def test_derivatives_agree_with_finite_differences(body, dome):
    skin = SkinMap.of(body)
    function = Quadratic(skin)

    def gradient(nodes):
        return skin.pull_back(nodes, function.gradient(skin.points(nodes))).reshape(-1)

    expected = derivative_by_points(lambda nodes: function.value(skin.points(nodes)), dome, STEP)
    assert np.abs(gradient(dome) - expected).max() < 1e-7 * np.abs(expected).max()
    by_points = function.gradient(skin.points(dome))
    hessian = skin.pull_back_hessian(dome, by_points, function.hessian()).toarray()
    expected = derivative_by_points(gradient, dome, STEP)
    assert np.abs(hessian - expected).max() < 1e-7 * np.abs(expected).max()


def test_the_map_has_a_curvature_of_its_own(body, dome):
    """Without it the stiffness is another one."""
    skin = SkinMap.of(body)
    function = Quadratic(skin)
    by_points = function.gradient(skin.points(dome))
    whole = skin.pull_back_hessian(dome, by_points, function.hessian())
    without = skin.pull_back_hessian(dome, 0 * by_points, function.hessian())
    assert np.abs(whole - without).max() > 1e-3 * np.abs(whole).max()


def test_a_rigid_motion_moves_the_skin_alike(body, dome):
    skin = SkinMap.of(body)
    turn, shift = Rotation.from_rotvec([0.7, -1.9, 0.4]), np.array([3e-3, -2e-3, 1e-3])
    moved = skin.points(turn.apply(dome) + shift)
    expected = turn.apply(skin.points(dome)) + shift
    assert np.abs(moved - expected).max() < 1e-9 * np.ptp(dome)


def test_flat_it_is_the_body_itself(body):
    flat = flat_surface(body.mesh)
    skin, expected = SkinMap.of(body), skin_of(body, flat)
    corners = skin.points(flat.points)[skin.triangles]
    assert np.abs(corners - expected.surface.corners).max() < 1e-12
    assert np.array_equal(skin.face, expected.face)


def test_on_a_sphere_layers_keep_their_volume(body):
    """The sheet is stretched onto a sphere: a fibre is shorter by the area stretch."""
    radius = 0.2
    points = flat_surface(body.mesh).points
    raised = points + np.array([0, 0, radius])
    sphere = radius * raised / np.linalg.norm(raised, axis=1)[:, None]
    skin = SkinMap.of(body)
    heights = np.linalg.norm(skin.points(sphere), axis=1) - radius
    surface = Surface(sphere, body.mesh.triangles)
    stretch = surface.node_areas / flat_surface(body.mesh).node_areas
    assert heights == pytest.approx(skin.heights / stretch[skin.node], abs=2e-5)


def test_it_takes_the_heights_of_another_prestretch(body):
    specimen = paper_specimen()
    thinner = BondedBody.of(specimen, body.mesh, (1.3, 1.3))
    assert np.array_equal(
        SkinMap.of(body).at_heights_of(thinner).heights, SkinMap.of(thinner).heights
    )


@pytest.mark.parametrize("layers", [1, 3])
def test_the_skin_is_closed_for_any_number_of_layers(body, layers):
    sheet = body.sheets[0]
    stack = [
        replace(sheet, bottom=number * 1e-3 - 5e-4, top=number * 1e-3 + 5e-4)
        for number in range(layers)
    ]
    skin = SkinMap.of(replace(body, sheets=stack))
    ends = np.sort(skin.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    _, count = np.unique(ends, axis=0, return_counts=True)
    assert set(count) == {2}
