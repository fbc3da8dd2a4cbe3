"""The Morley shell's energy: derivatives, rigid motions, constant curvature on any mesh."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from verification.derivatives import derivative

from bilayer import InputError, paper_specimen
from dshell.assembly import Assembly, deform
from dshell.morley import MorleyFaces
from dshell.morley_model import specimen_layers
from dshell.through_thickness import PROFILES, Laminate

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
            law=replace(
                layer.law,
                c10=1e-5 * layer.law.c10, c01=1e-5 * layer.law.c01, d1=1e5 * layer.law.d1,
            ),
        )
        for layer in layers
    ]  # fmt: skip
    laminate = Laminate(scaled, PROFILES[request.param])
    return MorleyFaces(1e3 * coarse_mesh.points, coarse_mesh.triangles, laminate)


@pytest.fixture
def state(faces, coarse_mesh):
    """A rough dome."""
    rng = np.random.default_rng(1)
    x, y = 1e3 * coarse_mesh.points.T
    dome = np.column_stack([0.95 * x, 0.97 * y, -0.01 * (x**2 + y**2)])
    dome += rng.uniform(-0.3, 0.3, dome.shape)
    return np.concatenate([dome.reshape(-1), rng.uniform(-0.3, 0.3, faces.edge_count)])


def test_gradient_is_the_derivative_of_the_energy(faces, state):
    values = state[faces.dofs]
    gradient = faces.at(values).gradient()
    expected = derivative(lambda x: faces.at(x).energy(), values, 1e-3)
    assert np.abs(gradient - expected).max() < 1e-7 * np.abs(gradient).max()


def test_hessian_is_the_derivative_of_the_gradient(faces, state):
    values = state[faces.dofs]
    hessian = faces.at(values).hessian()
    expected = derivative(lambda x: faces.at(x).gradient(), values, 1e-3)
    assert np.abs(hessian - expected).max() < 1e-7 * np.abs(hessian).max()
    assert np.allclose(hessian, hessian.transpose(0, 2, 1), atol=1e-10 * np.abs(hessian).max())


@pytest.mark.parametrize("size", [1, 7, 50])
def test_blocks_of_faces_are_the_faces(faces, state, size):
    """Some blocks have no kirigami; the prestretch differs from face to face."""
    rng = np.random.default_rng(3)
    substrate, kirigami = faces.laminate.layers
    stretched = 1.1 * np.eye(2)[:, :, None] + 0.02 * rng.uniform(size=(1, 1, len(faces.dofs)))
    on_top = 1 + 0.05 * np.eye(2)[:, :, None] * rng.uniform(size=(1, 1, len(kirigami.faces)))
    layers = [
        replace(substrate, prestretch=stretched),
        replace(kirigami, prestretch=on_top * np.eye(2)[:, :, None]),
    ]
    whole = faces.made_of(replace(faces.laminate, layers=layers))
    starts = range(0, len(faces.dofs), size)
    parts = [whole.part(slice(start, start + size)) for start in starts]
    expected = whole.at(state[whole.dofs])
    found = [part.at(state[part.dofs]) for part in parts]
    for name in ("energy", "gradient", "hessian", "convex_hessian"):
        values = getattr(expected, name)()
        joined = np.concatenate([getattr(part, name)() for part in found])
        assert np.abs(joined - values).max() < 1e-11 * np.abs(values).max(), name


def test_faces_of_a_layer_out_of_order_are_refused(faces):
    kirigami = faces.laminate.layers[1]
    with pytest.raises(InputError, match="faces of the layer kirigami: expected in ascending"):
        replace(kirigami, faces=kirigami.faces[::-1])


def test_convex_hessian_has_no_negative_eigenvalue(faces, state):
    convex = faces.at(state[faces.dofs]).convex_hessian()
    least = np.linalg.eigvalsh(convex)[:, 0]
    assert least.min() > -1e-9 * np.abs(convex).max()


def rotated(state, edges, rotation):
    nodes = rotation.apply(state[:-edges].reshape(-1, 3)) + np.array([3.0, -2.0, 1.0])
    return np.concatenate([nodes.reshape(-1), state[-edges:]])


def test_a_rigid_motion_changes_nothing(faces, state):
    rotation = Rotation.from_rotvec([0.7, -1.9, 0.4])
    moved = rotated(state, faces.edge_count, rotation)
    before, after = (faces.at(s[faces.dofs]).energy() for s in (state, moved))
    assert np.abs(after - before).max() < 1e-9 * np.abs(before).max()


def test_forces_are_in_balance(faces, state):
    assembly = Assembly(len(state), [faces.dofs])
    forces = assembly.gradient(deform([faces], state))[: -faces.edge_count].reshape(-1, 3)
    moments = np.cross(state[: -faces.edge_count].reshape(-1, 3), forces)
    assert np.abs(forces.sum(axis=0)).max() < 1e-9 * np.abs(forces).max()
    assert np.abs(moments.sum(axis=0)).max() < 1e-9 * np.abs(moments).max()


def test_layer_energies_add_up(faces, state):
    bent = faces.at(state[faces.dofs])
    parts = bent.layer_energies()
    assert set(parts) == {"substrate", "kirigami"}
    assert sum(parts.values()) == pytest.approx(bent.energy().sum())
