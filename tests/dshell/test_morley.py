"""The Morley shell's energy: derivatives, rigid motions, constant curvature on any mesh."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from verification.derivatives import derivative

from bilayer import InputError, paper_specimen
from dshell.energies.assembly import Assembly, gradient_of
from dshell.energies.morley_faces import MorleyFaces
from dshell.energies.through_thickness import PROFILES, Laminate
from dshell.models.morley import specimen_layers

STRETCH = (1.2, 1.1)


@pytest.fixture(params=PROFILES)
def faces(request, coarse_mesh):
    """A bilayer in millimetres and newtons, so that all its numbers are of order one to 100."""
    layers = specimen_layers(paper_specimen(), coarse_mesh, STRETCH)
    scaled = [
        replace(
            layer,
            bottom=1e3 * layer.bottom,
            top=1e3 * layer.top,
            law=replace(layer.law, law=scaled_law(layer.law.law)),
        )
        for layer in layers
    ]
    laminate = Laminate(scaled, PROFILES[request.param])
    return MorleyFaces(1e3 * coarse_mesh.points, coarse_mesh.triangles, laminate)


def scaled_law(law):
    """Return a Mooney-Rivlin law of stresses 1e5 times as small."""
    return replace(law, c10=1e-5 * law.c10, c01=1e-5 * law.c01, d1=1e5 * law.d1)


@pytest.fixture
def state(faces, coarse_mesh):
    """A rough dome."""
    rng = np.random.default_rng(1)
    x, y = 1e3 * coarse_mesh.points.T
    dome = np.column_stack([0.95 * x, 0.97 * y, -0.01 * (x**2 + y**2)])
    dome += rng.uniform(-0.3, 0.3, dome.shape)
    return np.concatenate([dome.reshape(-1), rng.uniform(-0.3, 0.3, faces.edge_count)])


def test_gradient_is_the_derivative_of_the_energy(faces, state):
    gradient = faces.at(state).gradient()
    expected = derivative(lambda x: faces.at(x).energy().sum(), state, 1e-3)
    assert np.abs(gradient - expected).max() < 1e-7 * np.abs(gradient).max()


def test_hessian_is_the_derivative_of_the_gradient(faces, state):
    bent = faces.at(state)
    hessian = whole(faces, bent.hessian())
    expected = derivative(lambda x: faces.at(x).gradient(), state, 1e-3)
    assert np.abs(hessian - expected).max() < 1e-7 * np.abs(hessian).max()
    for part in bent.hessian():
        assert np.allclose(part, part.transpose(0, 2, 1), atol=1e-10 * np.abs(part).max())


def whole(faces, parts):
    """The sum of the parts of a Hessian over their stencils."""
    size = max(stencil.max() for stencil in faces.stencils) + 1
    total = np.zeros((size, size))
    for stencil, part in zip(faces.stencils, parts, strict=True):
        np.add.at(total, (stencil[:, :, None], stencil[:, None, :]), part)
    return total


@pytest.mark.parametrize("size", [1, 7, 50])
def test_blocks_of_faces_are_the_faces(faces, state, size):
    """Some blocks have no kirigami; the prestretch differs from face to face."""
    rng = np.random.default_rng(3)
    substrate, kirigami = faces.laminate.layers
    count = faces.folds.shape[1]
    stretched = 1.1 * np.eye(2)[:, :, None] + 0.02 * rng.uniform(size=(1, 1, count))
    on_top = 1 + 0.05 * np.eye(2)[:, :, None] * rng.uniform(size=(1, 1, len(kirigami.faces)))
    layers = [
        replace(substrate, prestretch=stretched),
        replace(kirigami, prestretch=on_top * np.eye(2)[:, :, None]),
    ]
    layered = faces.with_laminate(replace(faces.laminate, layers=layers))
    starts = range(0, count, size)
    parts = [layered.part(slice(start, start + size)) for start in starts]
    expected = layered.at(state)
    found = [part.at(state) for part in parts]
    energy = np.concatenate([part.energy() for part in found])
    assert np.abs(energy - expected.energy()).max() < 1e-11 * np.abs(energy).max()
    forces = gradient_of(found)
    assert np.abs(forces - expected.gradient()).max() < 1e-11 * np.abs(forces).max()
    one, several = Assembly(len(state), [layered]), Assembly(len(state), parts)
    for name in ("hessian", "convex_hessian"):
        values = getattr(one, name)([expected])
        difference = getattr(several, name)(found) - values
        assert abs(difference).max() < 1e-11 * abs(values).max(), name


def test_around_a_node_of_three_triangles_two_neighbours_have_one_apex(faces):
    rng = np.random.default_rng(7)
    points = np.array([[0.1, 0.2], [4, -2], [0.5, 4], [-4, -3.0]])
    triangles = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1]])
    three = MorleyFaces(
        points, triangles, replace(faces.laminate, layers=faces.laminate.layers[:1])
    )
    state = rng.uniform(-0.3, 0.3, 3 * len(points) + three.edge_count)
    state[: 3 * len(points)].reshape(-1, 3)[:, :2] += points
    assembly = Assembly(len(state), [three])
    hessian = assembly.hessian([three.at(state)]).toarray()
    expected = derivative(lambda x: three.at(x).gradient(), state, 1e-3)
    assert np.abs(hessian - expected).max() < 1e-7 * np.abs(hessian).max()
    convex = assembly.convex_hessian([three.at(state)]).toarray()
    assert np.linalg.eigvalsh(convex)[0] > -1e-9 * np.abs(convex).max()


def test_faces_of_a_layer_out_of_order_are_refused(faces):
    kirigami = faces.laminate.layers[1]
    with pytest.raises(InputError, match="faces of the layer kirigami: expected in ascending"):
        replace(kirigami, faces=kirigami.faces[::-1])


def test_convex_hessian_has_no_negative_eigenvalue(faces, state):
    for convex in faces.at(state).convex_hessian():
        least = np.linalg.eigvalsh(convex)[:, 0]
        assert least.min() >= -1e-9 * np.abs(convex).max()


def rotated(state, edges, rotation):
    nodes = rotation.apply(state[:-edges].reshape(-1, 3)) + np.array([3.0, -2.0, 1.0])
    return np.concatenate([nodes.reshape(-1), state[-edges:]])


def test_a_rigid_motion_changes_nothing(faces, state):
    rotation = Rotation.from_rotvec([0.7, -1.9, 0.4])
    moved = rotated(state, faces.edge_count, rotation)
    before, after = (faces.at(s).energy() for s in (state, moved))
    assert np.abs(after - before).max() < 1e-9 * np.abs(before).max()


def test_forces_are_in_balance(faces, state):
    forces = faces.at(state).gradient()[: -faces.edge_count].reshape(-1, 3)
    moments = np.cross(state[: -faces.edge_count].reshape(-1, 3), forces)
    assert np.abs(forces.sum(axis=0)).max() < 1e-9 * np.abs(forces).max()
    assert np.abs(moments.sum(axis=0)).max() < 1e-9 * np.abs(moments).max()


def test_layer_energies_add_up(faces, state):
    bent = faces.at(state)
    parts = bent.layer_energies()
    assert set(parts) == {"substrate", "kirigami"}
    assert sum(parts.values()) == pytest.approx(bent.energy().sum())
