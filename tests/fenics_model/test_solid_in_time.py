"""Sheets that relax, released by the finite-element model; the shell beside it."""

from dataclasses import replace

import numpy as np
import pytest

import bilayer
from bilayer import MeshSize
from bilayer.results.comparison import compare
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.schedule import Schedule

pytest.importorskip("dolfinx")

SERIES = PronySeries(((0.4, 0.5), (0.3, 20.0)))
R = 0.04


@pytest.fixture(scope="module")
def sheet():
    return replace(bilayer.paper_specimen(), mesh=MeshSize(0.01)).with_milestones([1.06])


@pytest.fixture(scope="module")
def mesh(sheet):
    return bilayer.generate_mesh(sheet)


def relaxing(sheet, times, hold=0.0, steps_per_decade=2):
    """The sheet with a substrate that relaxes, looked at at some times."""
    slow = sheet.with_layer("substrate", relaxation=SERIES)
    return replace(slow, schedule=Schedule(times, hold, steps_per_decade))


@pytest.fixture(scope="module")
def timed(sheet):
    return relaxing(sheet, (0.0, 1.0, 1e6), hold=5.0)


@pytest.fixture(scope="module")
def whole(timed, mesh):
    return bilayer.solve(timed, "fenics", mesh=mesh)


def softened(sheet, factor):
    """The sheet with the constants of its substrate times a factor."""
    law = sheet.layer("substrate").material
    softer = replace(law, c10=factor * law.c10, c01=factor * law.c01, d1=law.d1 / factor)
    return sheet.with_layer("substrate", material=softer)


def shapes(specimen, mesh, **options):
    return bilayer.solve(specimen, "fenics", mesh=mesh, **options)["position"].values


def apart(one, other):
    return np.sqrt(np.mean(np.sum((one - other) ** 2, axis=-1))) / R


def test_at_time_zero_the_sheet_is_that_of_the_instantaneous_laws(sheet, mesh):
    (found,), (elastic,) = shapes(relaxing(sheet, (0.0,)), mesh), shapes(sheet, mesh)
    assert apart(found, elastic) < 1e-6


def test_after_long_it_is_that_of_the_relaxed_laws(sheet, mesh, whole):
    soft = bilayer.solve(softened(sheet, SERIES.relaxed_share), "fenics", mesh=mesh)
    (relaxed,) = soft["position"].values
    first, _, last = whole["position"].values
    assert apart(last, relaxed) < 1e-6
    assert apart(first, relaxed) > 0.02
    assert whole["time"].values.tolist() == [0.0, 1.0, 1e6]
    stress, expected = (bilayer.fields(each)["cauchy_stress"].values for each in (whole, soft))
    assert stress[2] == pytest.approx(expected[0], rel=1e-4, abs=0.1, nan_ok=True)  # Pa
    assert np.nanmax(np.abs(stress[0] - expected[0])) > 1e3


def test_the_shell_relaxes_alike(mesh, timed, whole):
    """On this coarse mesh the two are 0.9 % of R apart without time, too."""
    found = compare(whole, bilayer.solve(timed, "dshell", mesh=mesh))
    assert (found["rms_distance_over_radius"].values < 0.01).all()


def test_a_step_of_time_costs_no_more_than_a_milestone(whole):
    iterations, steps = (whole[name].values for name in ("iterations", "load_steps"))
    assert (iterations[1:] <= 1.3 * iterations[0] * steps[1:]).all()


def test_an_interrupted_run_goes_on_with_its_memory(timed, mesh, whole, tmp_path):
    file = tmp_path / "run.nc"

    def stop(step):
        if step.ends_target and step.index == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        shapes(timed, mesh, observers=[stop], output=file)
    assert np.array_equal(shapes(timed, mesh, resume=file), whole["position"].values)


@pytest.mark.mpi
def test_two_ranks_remember_what_one_does(timed, mesh):
    from mpi4py import MPI

    if MPI.COMM_WORLD.size == 1:
        pytest.skip("one rank: run under mpirun -n 2")
    two = timed.with_milestones(timed.prestretch.milestones[:2])
    early = replace(two, schedule=Schedule((0.0, 0.05), 5.0))
    alone, shared = (
        [
            point.save()
            for point in bilayer.follow(early, "fenics", mesh=mesh, comm=comm)
            if point.share == 1
        ][-1]
        for comm in (MPI.COMM_SELF, MPI.COMM_WORLD)
    )
    for name, tolerance in {"equilibrium": 1e-9, "memory.stress.0": 1e-2}.items():
        assert shared[name] == pytest.approx(alone[name], abs=tolerance)  # m, Pa
    assert np.abs(alone["memory.stress.0"]).max() > 1e3
