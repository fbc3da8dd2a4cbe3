"""The gradient of a design by the finite-element model: Taylor tests of families of its variables.

J(p + h) - J(p) - h dJ/dp falls with the square of h, J being found anew at each step from the
equilibrium of the design nearby.
"""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

import bilayer
from bilayer import MorleySettings
from bilayer.designing.equilibria import Model, SheetMesh, find_shape
from bilayer.designing.softness import least_stiffness
from bilayer.designing.variables import value_of, with_values
from bilayer.mesh.planar import flat_surface
from bilayer.solvers.contract import PointsLinearised, ShapeLinearised
from bilayer.solvers.registry import solver_named
from fenics_model import SOLVER, SolidSettings

FAMILIES = {
    "prestretch": 0.004,
    "substrate.thickness": 0.02,
    "kirigami.thickness": 0.01,
    "kirigami.modulus": 0.02,
    "kirigami.pattern.inner_radius": 0.03,
    "kirigami.pattern.half_angles.1": 0.03,
}
"""The first step of each, relative."""
MODEL = Model(SOLVER, SolidSettings(first_step=0.05))


@pytest.fixture(scope="module")
def design():
    """A specimen with its moving mesh and its shape, which is no shape that a symmetry holds."""
    pattern = bilayer.SectorProfile(5, (0.008, 0.022, 0.04), (0.12, 0.18, 0.24))
    specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=pattern)
    specimen = replace(specimen, mesh=bilayer.MeshSize(0.015)).with_milestones([(1.05, 1.04)])
    sheet = SheetMesh(specimen, bilayer.generate_mesh(specimen))
    with closing(find_shape(MODEL, specimen, sheet)) as shape:
        yield specimen, sheet, shape


def lengths(nodes):
    """Weighted squared lengths between nodes, which no rigid motion changes: value, gradient."""
    rng = np.random.default_rng(1)
    (first, second), weights = rng.integers(0, nodes, (2, 200)), rng.normal(size=200)

    def value(position):
        return weights @ ((position[first] - position[second]) ** 2).sum(axis=1)

    def gradient(position):
        bonds = 2 * weights[:, None] * (position[first] - position[second])
        total = np.zeros_like(position)
        np.add.at(total, first, bonds)
        np.add.at(total, second, -bonds)
        return total

    return value, gradient


@pytest.mark.parametrize("name", FAMILIES)
def test_the_remainder_is_of_second_order(design, name):
    specimen, sheet, shape = design
    value, gradient = lengths(len(sheet.mesh.points))
    position, saved = shape.equilibrium.position, shape.equilibrium.save()
    (slope,) = shape.gradient(gradient(position), [name])
    number, remainders = value_of(specimen, name), []
    for share in (1.0, 0.5):
        step = share * FAMILIES[name] * number
        changed = with_values(specimen, {name: number + step})
        with closing(find_shape(MODEL, changed, sheet, saved)) as there:
            found = value(there.equilibrium.position)
        remainders.append(found - value(position) - step * slope)
    rate = np.log2(abs(remainders[0] / remainders[1]))
    assert rate > 1.9
    assert abs(remainders[1]) < 0.2 * abs(FAMILIES[name] * number * slope)


def test_the_direct_derivative_is_that_of_the_adjoint(design):
    _, sheet, shape = design
    by_position = lengths(len(sheet.mesh.points))[1](shape.equilibrium.position)
    by_adjoint = shape.gradient(by_position, list(FAMILIES))
    directly = np.einsum("knx,nx->k", shape.changes(list(FAMILIES)), by_position)
    assert by_adjoint == pytest.approx(directly, rel=1e-6)
    assert isinstance(shape.linearised, ShapeLinearised)
    assert not isinstance(shape.linearised, PointsLinearised)


def test_the_expected_state_leads_straight_to_a_neighbour(design):
    """Thickness, cuts and prestretch at once; without what is expected it takes more."""
    specimen, sheet, shape = design
    names, steps = list(FAMILIES), [0.01, 3e-5, 5e-5, 4e3, 4e-4, 0.01]
    values = {name: value_of(specimen, name) + h for name, h in zip(names, steps, strict=True)}
    saved, change = shape.equilibrium.save(), np.array(steps) @ shape.state_changes(names)
    counts, positions = [], []
    for expected in (change, None):
        changed = with_values(specimen, values)
        with closing(find_shape(MODEL, changed, sheet, saved, expected)) as there:
            counts.append(there.equilibrium.effort.iterations)
            positions.append(there.equilibrium.position)
    assert counts[0] < counts[1]
    assert positions[0] == pytest.approx(positions[1], abs=1e-7)


def test_a_neighbour_is_moved_onto_the_held_points(design):
    """A saved state that has turned is the same equilibrium: hardly an iteration is needed."""
    from scipy.spatial.transform import Rotation

    specimen, sheet, shape = design
    saved = dict(shape.equilibrium.save())
    numbering = shape._path.numbering
    flat = numbering.places(shape._path.body.solid.mesh.volume.points)
    values = saved["equilibrium"][-1].copy()
    displacements = values[: flat.size].reshape(-1, 3)
    turn = Rotation.from_rotvec([0.3, -0.2, 0.5])
    displacements[:] = turn.apply(flat + displacements) + 0.01 - flat
    saved |= {
        "equilibrium": values[None],
        "equilibrium_parameter": saved["equilibrium_parameter"][-1:],
    }
    with closing(find_shape(MODEL, specimen, sheet, saved)) as again:
        assert again.equilibrium.effort.iterations <= 2
        away = again.equilibrium.position - shape.equilibrium.position
        assert np.abs(away).max() < 1e-7


def test_the_least_stiffness_is_that_of_the_shell(design):
    """Of a body with pressures and nodes through the thickness, by forces on its surface alone.

    On a mesh as coarse as this one the two models differ by a fifth.
    """
    specimen, sheet, shape = design
    areas = flat_surface(sheet.mesh).node_areas
    found = least_stiffness(shape.equilibrium, shape.linearised, areas)
    shell = Model(solver_named("dshell"), MorleySettings())
    with closing(find_shape(shell, specimen, sheet)) as thin:
        known = least_stiffness(thin.equilibrium, thin.linearised, areas)
    assert found == pytest.approx(known, rel=0.25)
