"""The gradient of a design by the shell: Taylor tests of every family of its variables.

J(p + h) - J(p) - h dJ/dp falls with the square of h, J being found anew at each step.
"""

from dataclasses import replace

import numpy as np
import pytest
from verification.derivatives import rough_dome

import bilayer
from bilayer import InputError
from bilayer.designing.distance import TargetDistance
from bilayer.designing.equilibria import Model, SheetMesh, find_shape
from bilayer.designing.gap import GapPenalty
from bilayer.designing.targets import cap
from bilayer.designing.variables import value_of, with_values
from bilayer.geometry.surface import Surface
from bilayer.solvers.contract import PointsLinearised
from dshell.solver import SOLVER

GAP_ANGLE = 0.03
"""Between the rims of the sheet rolled to a tube: 0.8 mm."""
TIGHT = bilayer.MorleySettings(tolerance=1e-11)
MODEL = Model(SOLVER, TIGHT)
FAMILIES = {
    "prestretch": 0.004,
    "prestretch.y": 0.002,
    "substrate.thickness": 0.02,
    "kirigami.thickness": 0.02,
    "kirigami.modulus": 0.02,
    "substrate.material.c01": 0.02,
    "kirigami.pattern.inner_radius": 0.02,
    "kirigami.pattern.half_angles.1": 0.02,
    "kirigami.pattern.half_angles.3": 0.02,
}
"""The first step of each, relative."""


@pytest.fixture(scope="module")
def design():
    """A specimen with its moving mesh and its shape, which is no shape that a symmetry holds."""
    pattern = bilayer.SectorProfile(5, (0.008, 0.019, 0.03, 0.04), (0.12, 0.16, 0.19, 0.24))
    specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=pattern)
    specimen = replace(specimen, mesh=bilayer.MeshSize(0.009)).with_milestones([(1.09, 1.07)])
    sheet = SheetMesh(specimen, bilayer.generate_mesh(specimen))
    return specimen, sheet, find_shape(MODEL, specimen, sheet)


@pytest.fixture(scope="module")
def distance(design):
    target = TargetDistance(cap(0.0255))
    return target, target.measure_anew(design[2].surface)


class Bonds:
    """A smooth function of a shape that no rigid motion changes: squared lengths, weighted."""

    def __init__(self, nodes):
        rng = np.random.default_rng(1)
        self._ends, self._weights = rng.integers(0, nodes, (2, 400)), rng.normal(size=400)

    def value(self, position):
        bonds = position[self._ends[0]] - position[self._ends[1]]
        return self._weights @ (bonds**2).sum(axis=1)

    def gradient(self, position):
        bonds = position[self._ends[0]] - position[self._ends[1]]
        total = np.zeros_like(position)
        np.add.at(total, self._ends[0], 2 * self._weights[:, None] * bonds)
        np.add.at(total, self._ends[1], -2 * self._weights[:, None] * bonds)
        return total


@pytest.mark.parametrize("name", FAMILIES)
def test_the_remainder_is_of_second_order(design, name):
    specimen, sheet, shape = design
    position, bonds = shape.equilibrium.position, Bonds(len(sheet.mesh.points))
    (slope,) = shape.gradient(bonds.gradient(position), [name])
    value, saved = value_of(specimen, name), shape.equilibrium.save()
    remainders = []
    for share in (1.0, 0.5):
        step = share * FAMILIES[name] * value
        there = find_shape(MODEL, with_values(specimen, {name: value + step}), sheet, saved)
        found = bonds.value(there.equilibrium.position)
        remainders.append(found - bonds.value(position) - step * slope)
    first = FAMILIES[name] * value * slope
    rate = np.log2(abs(remainders[0] / remainders[1]))
    assert rate > 1.9
    assert abs(remainders[1]) < 0.2 * abs(first)


def test_the_distance_falls_as_its_gradient_says(design, distance):
    """Not quite smooth: a nearest point changes its triangle."""
    specimen, sheet, shape = design
    target, here = distance
    name, share = "kirigami.thickness", 0.01
    (slope,) = shape.gradient(here.gradient, [name])
    step = share * value_of(specimen, name)
    saved, values = shape.equilibrium.save(), []
    for sign in (1, -1):
        changed = with_values(specimen, {name: value_of(specimen, name) + sign * step})
        there = find_shape(MODEL, changed, sheet, saved)
        values.append(target.measure(there.surface, here.place).mean_square)
    assert slope == pytest.approx((values[0] - values[1]) / (2 * step), rel=0.01)


def test_the_direct_derivative_is_that_of_the_adjoint(design, distance):
    """One solution for each variable says what one for all of them does."""
    _, _, shape = design
    by_adjoint = shape.gradient(distance[1].gradient, list(FAMILIES))
    changes = shape.changes(list(FAMILIES))
    directly = np.einsum("knx,nx->k", changes, distance[1].gradient)
    assert by_adjoint == pytest.approx(directly, rel=2e-4, abs=1e-7 * np.abs(directly).max())


def test_the_energy_by_the_flat_nodes_is_that_of_finite_differences(coarse_specimen, coarse_mesh):
    path = SOLVER.open_path(
        coarse_specimen, TIGHT, mesh=coarse_mesh, start=None, comm=None, progress=None
    )
    shell = path._shell
    rough = rough_dome(coarse_mesh, shell.model.extra_dofs)
    state = np.concatenate([rough, np.zeros(shell.model.fold_count)])
    found = shell.model.flat_gradient((1.1, 1.07), state)

    def energy(points):
        model = shell.on(coarse_mesh.with_points(points)).model
        return sum(faces.at(state).energy().sum() for faces in model.energies((1.1, 1.07)))

    rng = np.random.default_rng(3)
    for _ in range(3):
        way = rng.normal(size=found.shape)
        step = 1e-7
        ahead, behind = (energy(coarse_mesh.points + sign * step * way) for sign in (1, -1))
        assert np.sum(found * way) == pytest.approx((ahead - behind) / (2 * step), rel=1e-6)


def test_the_gap_penalty_is_differentiated_by_shape_and_numbers(design):
    """On the sheet rolled to a tube, whose rims nearly meet."""
    pytest.importorskip("ipctk")
    specimen, sheet, _ = design
    penalty = GapPenalty(sheet, 0.02)
    names = ["kirigami.thickness", "kirigami.pattern.half_angles.2"]
    x, y = sheet.mesh.points.T
    angle = x / 0.04 * (np.pi - GAP_ANGLE)
    radius = 0.04 / np.pi
    rolled = np.column_stack([radius * np.sin(angle), y, radius * np.cos(angle)])
    value, by_position, by_numbers = penalty.at(specimen, rolled, names)
    assert value > 0
    way = np.sin(np.arange(rolled.size)).reshape(-1, 3)
    step = 1e-7
    ahead, behind = (penalty.at(specimen, rolled + s * step * way, [])[0] for s in (1, -1))
    assert np.sum(by_position * way) == pytest.approx((ahead - behind) / (2 * step), rel=1e-4)
    for name, slope in zip(names, by_numbers, strict=True):
        number = value_of(specimen, name)
        values = [
            penalty.at(with_values(specimen, {name: number * (1 + s * 1e-4)}), rolled, [])[0]
            for s in (1, -1)
        ]
        assert slope == pytest.approx((values[0] - values[1]) / (2e-4 * number), rel=1e-3)


def test_weight_contact_and_hinges_are_refused(coarse_specimen, coarse_mesh):
    light = coarse_specimen.with_milestones([1.01])
    for specimen, settings in (
        (replace(light, gravity=9.81), bilayer.MorleySettings()),
        (light, bilayer.HingeSettings()),
    ):
        (*_, last) = bilayer.follow(specimen, "dshell", settings, mesh=coarse_mesh)
        equations = last.linearised()
        assert isinstance(equations, PointsLinearised)
        with pytest.raises(InputError, match="points_gradient"):
            equations.points_gradient(np.zeros(3), last.position)


def test_the_shape_of_a_design_is_that_of_a_run(design):
    specimen, sheet, shape = design
    result = bilayer.solve(specimen, "dshell", TIGHT, mesh=sheet.mesh)
    assert np.abs(result["position"].values[-1] - shape.equilibrium.position).max() < 1e-9
    assert isinstance(shape.surface, Surface)
