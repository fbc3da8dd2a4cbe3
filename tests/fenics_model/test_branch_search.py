"""Off an unstable equilibrium: its modes, the walk along one, the choice of a branch."""

import numpy as np
import psutil
import pytest

pytest.importorskip("dolfinx")

from verification.buckled_plate import LENGTH, THICKNESS, BuckledPlate
from verification.solid_problem import push

from fenics_model.branches.branch_search import BranchSearch, SearchRule
from fenics_model.branches.buckling_modes import (
    buckling_modes,
    least_stiffness,
    rms_displacement,
)
from fenics_model.release.branch_fields import branch_dataset
from fenics_model.solve.effort import Effort


@pytest.fixture(scope="module")
def shared_plate():
    """The flat plate with one unstable mode."""
    plate = BuckledPlate()
    yield plate
    plate.close()


@pytest.fixture
def plate(shared_plate):
    """The plate without a load."""
    push(shared_plate.solid, 0.0)
    return shared_plate


def find_modes(plate, beside=0):
    """The unstable modes of the flat plate, and how many the inertia counts."""
    counted = plate.unstable_modes(plate.flat)
    with plate.newton.factorise(plate.flat) as factors:
        side = plate.lift(1.0)
        return buckling_modes(factors, plate.newton.mass, counted + beside, side), counted


@pytest.mark.mpi
@pytest.mark.parametrize("compression", [0.93, 0.8])
def test_the_modes_are_as_many_as_the_inertia_counts(compression):
    """SLEPc's eigenvalues and MUMPS' pivots are two ways to the same number."""
    plate = BuckledPlate(compression)
    found, counted = find_modes(plate, beside=4)
    assert len(found) == counted
    assert (counted > 1) == (compression < 0.9)
    assert [mode.stiffness for mode in found] == sorted(mode.stiffness for mode in found)
    layout, mass = plate.newton.layout, plate.newton.mass
    for mode in found:
        assert rms_displacement(mode.direction, mass, layout) == pytest.approx(1.0)
        inertia = mode.stiffness * mass.times(mode.direction)
        with (
            plate.newton.factorise(plate.flat) as factors,
            layout.vectors(mode.direction, None) as (along, force),
        ):
            factors.matrix.mult(along, force)
            left = layout.read(force) - inertia
        assert layout.norm(left) < 1e-5 * layout.norm(inertia)
    plate.close()


def test_soft_stable_modes_hide_no_unstable_one_that_is_far_from_zero():
    """A spring of negative stiffness at one node of a plate whose bending modes are soft."""
    plate = BuckledPlate(compression=1.1)
    middle = int(np.argmax(plate.lift(1.0)))
    plate.solid.nodal.grip([middle], -100.0, 0.0)
    found, counted = find_modes(plate)
    assert len(found) == counted == 1
    with plate.newton.factorise(plate.flat) as factors:
        soft = least_stiffness(factors, plate.newton.mass, plate.lift(1.0))
    assert 0 < soft < -found[0].stiffness / 10
    plate.close()


@pytest.mark.mpi
def test_both_sides_of_a_symmetric_plate_are_stable_and_as_low_as_each_other(plate):
    departure = plate.leave(plate.flat, plate.search())
    before, plus, minus = departure.branches
    assert (before.unstable_modes, plus.unstable_modes, minus.unstable_modes) == (1, 0, 0)
    assert plus.energy < before.energy
    assert minus.energy == pytest.approx(plus.energy, rel=1e-9)
    assert departure.taken == "plus"
    assert departure.effort.escapes == 1
    taken = departure.equilibrium.state
    assert plate.rise(taken) > 1e-4
    assert plate.newton.residual_norm(taken) <= plate.tolerance
    assert plate.unstable_modes(taken) == 0


@pytest.mark.mpi
@pytest.mark.parametrize(
    ("choice", "weight", "side"),
    [("lowest", -3e3, "minus"), ("lowest", 3e3, "plus"), ("other", -3e3, "plus")],
)
def test_under_a_load_one_side_is_lower_and_the_choice_decides(plate, choice, weight, side):
    push(plate.solid, weight)
    search = plate.search(rule=SearchRule(choice=choice))
    departure = plate.leave(plate.solved(plate.flat), search)
    _, plus, minus = departure.branches
    assert (minus.energy < plus.energy) == (weight < 0)
    assert departure.taken == side
    assert (plate.rise(departure.equilibrium.state) > 0) == (side == "plus")


def smooth_changes(plate, count):
    """Random smooth changes of the displacements, zero at the clamps, of 10 micrometres."""
    rng = np.random.default_rng(7)
    for _ in range(count):
        frequency, phase = rng.uniform(-800, 800, (3, 3)), rng.uniform(0, 6, (3, 1))
        yield plate.solid.interpolate(
            lambda x, f=frequency, p=phase: 1e-5 * np.sin(np.pi * x[0] / LENGTH) * np.cos(f @ x + p)
        ).values


def test_whatever_disturbs_a_stable_shape_raises_its_energy(plate):
    """And what disturbs the flat one along its mode lowers it."""
    ((mode,), _) = find_modes(plate)
    assert plate.relaxed_energy(plate.flat + 1e-5 * mode.direction) < plate.energy(plate.flat)
    taken = plate.leave(plate.flat, plate.search()).equilibrium.state
    for change in smooth_changes(plate, 6):
        assert plate.relaxed_energy(taken + change) > plate.energy(taken)


def test_who_wants_the_unstable_shape_gets_it_with_the_energies_of_the_others(plate):
    search = plate.search(rule=SearchRule(choice="unstable"))
    departure = plate.leave(plate.flat, search)
    assert departure.equilibrium is None
    assert departure.taken == "left"
    assert departure.unstable_modes == 1
    assert all(branch.energy < departure.branches[0].energy for branch in departure.branches[1:])


@pytest.mark.mpi
def test_a_search_that_finds_nothing_stays(plate):
    search = plate.search(first_distance=100 * THICKNESS, step_limit=0)
    departure = plate.leave(plate.flat, search)
    assert departure.equilibrium is None
    assert [branch.unstable_modes for branch in departure.branches] == [1, -1, -1]


@pytest.mark.parametrize(("landings", "stable"), [(1, False), (12, True)])
def test_a_search_goes_on_from_one_unstable_shape_to_the_next(monkeypatch, landings, stable):
    """The first landing of either side is flat; what follows is not."""
    plate = BuckledPlate()
    flat, land, landed = plate.newton.solve(plate.flat, plate.tolerance), BranchSearch._land, []

    def land_flat_first(self, state, mode, sign, tolerance, reference):
        landed.append(sign)
        if landed.count(sign) == 1:
            return flat, Effort(1)
        return land(self, state, mode, sign, tolerance, reference)

    monkeypatch.setattr(BranchSearch, "_land", land_flat_first)
    departure = plate.leave(plate.flat, plate.search(rule=SearchRule(landings=landings)))
    assert (departure.unstable_modes == 0) == stable
    assert departure.unstable_modes == plate.unstable_modes(departure.equilibrium.state)
    assert len(landed) == 2 * min(landings, 2)
    plate.close()


def test_the_dataset_tells_what_was_found(plate):
    departure = plate.leave(plate.flat, plate.search())
    data = branch_dataset([None, departure], 3)
    assert data["branch"].values.tolist() == ["left", "plus", "minus"]
    assert data["branch_taken"].values.tolist() == [-1, 1, -1]
    assert data["branch_unstable_modes"].values.tolist() == [[-1] * 3, [1, 0, 0], [-1] * 3]
    energy = data["branch_energy"].values
    assert np.isnan(energy[[0, 2]]).all()
    assert energy[1].tolist() == [branch.energy for branch in departure.branches]


def resident():
    """Memory of this process, bytes."""
    return psutil.Process().memory_info().rss


@pytest.mark.mpi
def test_searches_leave_no_memory_behind(plate):
    """On several ranks what is left to a collector is never freed."""
    if plate.newton.layout.comm.size == 1:
        pytest.skip("one rank: run under mpirun -n 2")
    search = plate.search()
    plate.leave(plate.flat, search)  # so that everything is compiled and the heap has its size
    plate.leave(plate.flat, search)
    before = resident()
    for _ in range(50):
        plate.leave(plate.flat, search)
    assert resident() - before < 2**20
