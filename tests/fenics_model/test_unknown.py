"""The unknown of a form and the present state, which derivatives take for a constant."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from fenics_model.solid.unknown import Unknown, at_state, freeze


@pytest.fixture
def unknown():
    space = fem.functionspace(mesh.create_unit_cube(MPI.COMM_WORLD, 1, 1, 1), ("Lagrange", 1))
    function = Unknown(space)
    function.interpolate(lambda x: 1 + x[0] + x[1] ** 2)
    return function


def integral(expression):
    return fem.assemble_scalar(fem.form(expression * ufl.dx))


def test_what_is_frozen_has_the_present_value_and_no_derivative(unknown):
    square = freeze(unknown**2)
    along = fem.Function(unknown.function_space)
    along.x.array[:] = np.arange(1.0, 1 + len(along.x.array))
    slope = ufl.derivative(square * unknown, unknown, along)
    unknown.x.array[:] += 0.5
    assert integral(square) == pytest.approx(integral(unknown**2), rel=1e-14)
    assert integral(slope) == pytest.approx(integral(unknown**2 * along), rel=1e-14)


def test_a_variable_is_frozen_with_what_it_stands_for(unknown):
    variable = ufl.variable(unknown)
    slope = ufl.diff(freeze(variable) * variable**2, variable)
    assert integral(slope) == pytest.approx(integral(2 * unknown**2), rel=1e-14)


def test_an_expression_at_another_state_is_there_altogether(unknown):
    other = fem.Function(unknown.function_space)
    other.interpolate(lambda x: 3 - x[2])
    there = at_state(freeze(unknown) ** 2 * unknown, unknown, other)
    assert integral(there) == pytest.approx(integral(other**3), rel=1e-14)
