"""The solid's derivatives, its invariances and its stability count (rung 14)."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from mpi4py import MPI
from verification.buckled_plate import BuckledPlate
from verification.solid_derivatives import (
    PAIRS,
    derivative_errors,
    rigid_motion_error,
    strained_solid,
)

from fenics_model.branches.stability import unstable_modes


@pytest.fixture(params=PAIRS)
def strained(request):
    return strained_solid(PAIRS[request.param])


@pytest.mark.mpi
def test_residual_and_tangent_are_derivatives_of_the_energy(strained):
    residual, tangent = derivative_errors(strained)
    assert residual < 1e-7
    assert tangent < 1e-7


@pytest.mark.mpi
def test_a_rigid_motion_changes_neither_energy_nor_residual(strained):
    assert rigid_motion_error(strained) < 1e-9


@pytest.mark.mpi
@pytest.mark.parametrize("compression", [1.05, 0.93])
def test_the_inertia_counts_the_unstable_modes(compression):
    """A clamped thin plate: in tension stable, in compression unstable though in balance."""
    plate = BuckledPlate(compression)
    counted = unstable_modes(plate.newton, plate.solid.number_of_pressures)
    if MPI.COMM_WORLD.size == 1:
        indptr, columns, entries = plate.newton.matrix.getValuesCSR()
        dense = np.zeros((len(indptr) - 1,) * 2)
        dense[np.repeat(np.arange(len(dense)), np.diff(indptr)), columns] = entries
        negative = int(np.sum(np.linalg.eigvalsh(dense) < 0))
        assert counted == negative - plate.solid.number_of_pressures
    assert (counted == 0) == (compression > 1)
    plate.newton.destroy()


def test_after_a_failed_factorisation_the_next_one_counts_again():
    plate = BuckledPlate()
    values = plate.solid.state.x.array
    kept = values.copy()
    values[:] = np.nan
    assert unstable_modes(plate.newton, plate.solid.number_of_pressures) == -1
    values[:] = kept + np.random.default_rng(0).normal(scale=0.1, size=len(kept))
    unstable_modes(plate.newton, plate.solid.number_of_pressures)
    values[:] = kept
    assert unstable_modes(plate.newton, plate.solid.number_of_pressures) == 1
    plate.newton.destroy()
