"""The solid's derivatives, its invariances and its stability count (rung 14)."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc
from verification.buckled_plate import BuckledPlate
from verification.solid_derivatives import (
    PAIRS,
    derivative_errors,
    rigid_motion_error,
    strained_solid,
)
from verification.solid_problem import newton_of

from fenics_model.solid.state import State
from fenics_model.solve.factors import ExpiredFactorsError


@pytest.fixture(params=PAIRS)
def strained(request):
    return strained_solid(PAIRS[request.param])


@pytest.mark.mpi
def test_residual_and_tangent_are_derivatives_of_the_energy(strained):
    residual, tangent = derivative_errors(*strained)
    assert residual < 1e-7
    assert tangent < 1e-7


@pytest.mark.mpi
def test_a_rigid_motion_changes_neither_energy_nor_residual(strained):
    assert rigid_motion_error(*strained) < 1e-9


@pytest.mark.mpi
@pytest.mark.parametrize("compression", [1.05, 0.93])
def test_the_inertia_counts_the_unstable_modes(compression):
    """A clamped thin plate: in tension stable, in compression unstable though in balance."""
    plate = BuckledPlate(compression)
    counted = plate.unstable_modes(plate.flat)
    if MPI.COMM_WORLD.size == 1:
        with plate.newton.factorise(plate.flat) as factors:
            indptr, columns, entries = factors.matrix.getValuesCSR()
        dense = np.zeros((len(indptr) - 1,) * 2)
        dense[np.repeat(np.arange(len(dense)), np.diff(indptr)), columns] = entries
        negative = int(np.sum(np.linalg.eigvalsh(dense) < 0))
        assert counted == negative - plate.solid.number_of_pressures
    assert (counted == 0) == (compression > 1)
    plate.close()


@pytest.fixture
def plate():
    plate = BuckledPlate()
    yield plate
    plate.close()


def test_after_a_failed_factorisation_the_next_one_counts_again(plate):
    assert plate.unstable_modes(State(np.full_like(plate.flat.values, np.nan))) == -1
    noise = np.random.default_rng(0).normal(scale=0.1, size=len(plate.flat.values))
    plate.unstable_modes(plate.flat + noise)
    assert plate.unstable_modes(plate.flat) == 1


def test_nobody_changes_a_state(plate):
    with pytest.raises(ValueError, match="read-only"):
        plate.flat.values[0] = 1.0
    ones = np.ones_like(plate.flat.values)
    state = State(ones)
    ones[:] = 2.0
    assert (state.values == 1.0).all()


def test_the_state_is_what_it_was_also_after_an_error(plate):
    plate.solid.move_to(plate.flat)
    with pytest.raises(RuntimeError, match="inside"), plate.solid.at(plate.solid.undeformed):
        raise RuntimeError("inside")
    assert np.array_equal(plate.solid.unknown.x.array, plate.flat.values)


@pytest.mark.parametrize("ends", ["release", "factorise", "solve", "close"])
def test_factors_are_good_until_the_solver_is_used_again(plate, ends):
    right = np.zeros_like(plate.flat.values)
    factors = plate.newton.factorise(plate.flat)
    assert factors.solve(right) == pytest.approx(right, abs=0)
    {
        "release": factors.release,
        "factorise": lambda: plate.newton.factorise(plate.flat),
        "solve": lambda: plate.newton.solve(plate.flat, plate.tolerance),
        "close": plate.newton.close,
    }[ends]()
    with pytest.raises(ExpiredFactorsError):
        factors.solve(right)


def test_the_matrix_of_the_tangent_has_all_of_its_entries_and_few_zeros():
    """Two layers: what couples a cell with the pressure of the other one is left out, and zero."""
    solid, state = strained_solid(PAIRS["mooney-rivlin"])
    held = solid.absent_pressures()
    with newton_of(solid, []) as newton, solid.at(state):
        own = newton.factorise(state).matrix
        full = fem_petsc.create_matrix(solid.tangent.form)
        fem_petsc.assemble_matrix(full, solid.tangent.form, held)
        full.assemble()
        used = own.getInfo()["nz_used"]
        assert used < full.getInfo()["nz_used"]
        scale = full.norm()
        full.axpy(-1.0, own, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        assert full.norm() < 1e-13 * scale
        full.destroy()
