"""Off an unstable equilibrium: its modes, the walk along one, the choice of a branch."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from dolfinx import fem
from verification.buckled_plate import LENGTH, THICKNESS, BuckledPlate
from verification.solid_problem import push

from fenics_model.branches.buckling_modes import buckling_modes, rms_displacement
from fenics_model.release.branch_fields import branch_dataset


@pytest.fixture(scope="module")
def plate():
    """The flat plate with one unstable mode; each test begins in that state, without a load."""
    made = BuckledPlate()
    made.flat = made.solid.state.x.array.copy()
    yield made
    made.newton.destroy()


@pytest.fixture(autouse=True)
def flat(plate):
    plate.solid.state.x.array[:] = plate.flat
    push(plate.solid, 0.0)


def left(plate, **options):
    search = plate.search(**options)
    return search.leave(search.flow.unstable_modes(), plate.tolerance, plate.reference)


@pytest.mark.mpi
@pytest.mark.parametrize("compression", [0.93, 0.8])
def test_the_modes_are_as_many_as_the_inertia_counts(compression):
    """SLEPc's eigenvalues and MUMPS' pivots are two ways to the same number."""
    plate = BuckledPlate(compression)
    search = plate.search()
    counted = search.flow.unstable_modes()
    side = plate.lift(1.0)
    found = buckling_modes(plate.newton, search.flow.mass, counted + 4, side)
    assert len(found) == counted
    assert (counted > 1) == (compression < 0.9)
    assert [mode.stiffness for mode in found] == sorted(mode.stiffness for mode in found)
    for mode in found:
        along, tangent, inertia = (plate.newton.vector() for _ in range(3))
        along.array[:] = mode.direction
        assert rms_displacement(along, search.flow.mass) == pytest.approx(1.0)
        search.flow.mass.mult(along, inertia)
        plate.newton.matrix.mult(along, tangent)
        tangent.axpy(-mode.stiffness, inertia)
        assert tangent.norm() < 1e-5 * abs(mode.stiffness) * inertia.norm()
    plate.newton.destroy()


@pytest.mark.mpi
def test_both_sides_of_a_symmetric_plate_are_stable_and_as_low_as_each_other(plate):
    departure = left(plate)
    before, plus, minus = departure.branches
    assert (before.unstable_modes, plus.unstable_modes, minus.unstable_modes) == (1, 0, 0)
    assert plus.energy < before.energy
    assert minus.energy == pytest.approx(plus.energy, rel=1e-9)
    assert departure.taken == "plus"
    assert departure.effort.escapes == 1
    assert plate.rise() > 1e-4
    assert plate.newton.residual_norm() <= plate.tolerance
    assert plate.search().flow.unstable_modes() == 0


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("choice", "weight", "side"),
    [("lowest", -3e3, "minus"), ("lowest", 3e3, "plus"), ("other", -3e3, "plus")],
)
def test_under_a_load_one_side_is_lower_and_the_choice_decides(plate, choice, weight, side):
    push(plate.solid, weight)
    plate.solved()
    departure = left(plate, choice=choice)
    _, plus, minus = departure.branches
    assert (minus.energy < plus.energy) == (weight < 0)
    assert departure.taken == side
    assert (plate.rise() > 0) == (side == "plus")


def smooth_changes(plate, count):
    """Random smooth changes of the displacements, zero at the clamps, of 10 micrometres."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        frequency, phase = rng.uniform(-800, 800, (3, 3)), rng.uniform(0, 6, (3, 1))
        change = fem.Function(plate.solid.space)
        change.sub(0).interpolate(
            lambda x, f=frequency, p=phase: 1e-5 * np.sin(np.pi * x[0] / LENGTH) * np.cos(f @ x + p)
        )
        yield change.x.array


def test_whatever_disturbs_a_stable_shape_raises_its_energy(plate):
    """And what disturbs the flat one along its mode lowers it."""
    search = plate.search()
    modes = search.flow.unstable_modes()
    (mode,) = buckling_modes(plate.newton, search.flow.mass, modes, plate.lift(1.0))
    assert plate.energy_at(1e-5 * mode.direction) < plate.energy()
    left(plate)
    least = plate.energy()
    for change in smooth_changes(plate, 6):
        assert plate.energy_at(change) > least


def test_who_wants_the_unstable_shape_gets_it_with_the_energies_of_the_others(plate):
    departure = left(plate, choice="unstable")
    assert departure.equilibrium is None
    assert departure.taken == "left"
    assert departure.unstable_modes == 1
    assert plate.solid.state.x.array == pytest.approx(plate.flat, abs=0)
    assert all(branch.energy < departure.branches[0].energy for branch in departure.branches[1:])


@pytest.mark.mpi
def test_a_search_that_finds_nothing_leaves_the_state(plate):
    departure = left(plate, first_distance=100 * THICKNESS, step_limit=0)
    assert departure.equilibrium is None
    assert [branch.unstable_modes for branch in departure.branches] == [1, -1, -1]
    assert plate.solid.state.x.array == pytest.approx(plate.flat, abs=0)


def test_the_dataset_tells_what_was_found(plate):
    departure = left(plate)
    data = branch_dataset([None, departure], 3)
    assert data["branch"].values.tolist() == ["left", "plus", "minus"]
    assert data["branch_taken"].values.tolist() == [-1, 1, -1]
    assert data["branch_unstable_modes"].values.tolist() == [[-1] * 3, [1, 0, 0], [-1] * 3]
    energy = data["branch_energy"].values
    assert np.isnan(energy[[0, 2]]).all()
    assert energy[1].tolist() == [branch.energy for branch in departure.branches]
