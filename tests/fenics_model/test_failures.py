"""Failures are reported in words, and leave nothing behind."""

import os
import signal
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from contextlib import contextmanager

from verification.buckled_plate import BuckledPlate
from verification.solid_problem import newton_of

from bilayer import InputError, MeshSize, generate_mesh, paper_specimen
from bilayer import solve as bilayer_solve
from bilayer.errors import ComputationError, Interrupted
from fenics_model import SolidSettings
from fenics_model.solve.factors import Factors
from fenics_model.solve.stopwatch import Stopwatch

COARSE = replace(paper_specimen(), mesh=MeshSize(0.016))


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(COARSE)


def solve(specimen, settings=None, **options):
    """Load steps from flat."""
    return bilayer_solve(specimen, "fenics", settings, start="flat", **options)


def hasty(**changes):
    """Settings that fail at a step of 0.5."""
    return SolidSettings(
        first_step=0.5, smallest_step=0.3, largest_step=0.5, flow_steps=0, **changes
    )


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ("-bilayer_ksp_type nonsense", "nonsense"),
        ("-bilayer_ksp_tipe preonly", "-bilayer_ksp_tipe is not one of those used"),
        ("-ksp_view", "names that begin with -bilayer_"),
    ],
)
def test_wrong_options_are_input_errors_in_one_line(mesh, options, complaint):
    with pytest.raises(InputError, match=complaint) as raised:
        solve(COARSE.with_milestones([1.01]), SolidSettings(petsc_options=options), mesh=mesh)
    assert len(str(raised.value).splitlines()) == 1


def test_options_that_are_used_are_fine(mesh):
    settings = SolidSettings(petsc_options="-bilayer_mat_mumps_icntl_14 60")
    assert solve(COARSE.with_milestones([1.005]), settings, mesh=mesh)["converged"].values[0] == 1


def test_a_factorisation_without_memory_says_so_and_keeps_what_was_reached(mesh):
    """MUMPS may use 1 MB (ICNTL(23)), which is not enough."""
    settings = hasty(petsc_options="-bilayer_mat_mumps_icntl_23 1 -bilayer_mat_mumps_icntl_14 0")
    result = solve(COARSE.with_milestones([1.3]), settings, mesh=mesh)
    assert result["converged"].values.tolist() == [0]
    assert "stopped at prestretch 1:" in result.attrs["stop_reason"]
    assert "the factorisation failed" in result.attrs["stop_reason"]


def test_a_solution_without_factors_says_why_there_are_none():
    """PETSc's own words are that an argument is in the wrong state (its error 73)."""
    plate = BuckledPlate()
    with plate.newton.factorise(plate.flat) as factors:
        failed = Factors(factors.solver, factors.matrix, factors.layout, "PETSc: out of memory")
        with pytest.raises(ComputationError, match=r"^PETSc: out of memory$"):
            failed.solve(plate.lift(1.0))
    assert plate.newton.solve(plate.flat, plate.tolerance).converged  # nothing is left of it
    plate.close()


def test_a_milestone_without_time_ends_the_run_in_words(mesh, tmp_path):
    specimen, output = COARSE.with_milestones([1.01]), tmp_path / "run.nc"
    stopped = solve(specimen, mesh=mesh, limit=1e-6, output=output)
    assert stopped["converged"].values.tolist() == [0]
    reason = "stopped at prestretch 1: the time limit for a milestone is over"
    assert stopped.attrs["stop_reason"] == reason
    whole = solve(specimen, mesh=mesh, output=output, resume=output)
    alone = solve(specimen, mesh=mesh)
    assert np.array_equal(whole["position"].values, alone["position"].values)


def test_a_failed_run_leaves_nothing_behind(mesh):
    """Alone, after another and after a failed one the result is the same to the last bit."""
    specimen = COARSE.with_milestones([1.01, 1.02])
    alone = solve(specimen, mesh=mesh)
    again = solve(specimen, mesh=mesh)
    failed = solve(COARSE.with_milestones([1.9]), hasty(), mesh=mesh)
    assert failed["converged"].values.tolist() == [0]
    after = solve(specimen, mesh=mesh)
    for result in (again, after):
        assert np.array_equal(result["volume_position"].values, alone["volume_position"].values)
        assert result["iterations"].values.tolist() == alone["iterations"].values.tolist()


@pytest.fixture(params=[signal.SIGINT, signal.SIGTERM])
def sent(request):
    """A signal that raises KeyboardInterrupt."""
    before = signal.signal(request.param, signal.default_int_handler)
    yield request.param
    signal.signal(request.param, before)


def test_an_interruption_keeps_the_milestones_done(mesh, sent):
    def interrupt(fraction, message):
        if fraction > 0.6:
            os.kill(os.getpid(), sent)

    with pytest.raises(Interrupted) as raised:
        solve(COARSE.with_milestones([1.01, 1.02, 1.03]), mesh=mesh, progress=interrupt)
    kept = raised.value.result
    assert kept["converged"].values[0] == 1
    assert kept["converged"].values[-1] == 0
    assert kept.attrs["stop_reason"] == "interrupted"
    whole = solve(COARSE.with_milestones([1.01]), mesh=mesh)
    assert kept["position"].values[0] == pytest.approx(whole["position"].values[0], abs=1e-9)


class InterruptingStopwatch(Stopwatch):
    """Sends this process a signal while PETSc has an assembly done, once."""

    def __init__(self, sent):
        super().__init__()
        self._sent = [sent]

    @contextmanager
    def time_assembly(self):
        if self._sent:
            os.kill(os.getpid(), self._sent.pop())
        with super().time_assembly():
            yield


def test_an_interruption_within_petsc_waits_for_its_end(sent):
    """An exception may not pass through it; afterwards all is as before."""
    plate = BuckledPlate()
    guess = plate.flat + plate.lift(1e-4)
    with newton_of(plate.solid, [], stopwatch=InterruptingStopwatch(sent)) as newton:
        with pytest.raises(KeyboardInterrupt):
            newton.solve(guess, plate.tolerance)
        again = newton.solve(plate.flat, plate.tolerance)
        assert again.state is not None
    assert plate.solved(plate.flat) is not None
    plate.close()


def test_the_work_is_counted(mesh):
    result = solve(COARSE.with_milestones([1.01, 1.02]), mesh=mesh)
    stable = 1  # factorisation for the inertia, by milestone
    counted = result["iterations"].values + stable
    assert result["factorisations"].values.tolist() == counted.tolist()
    parts = result["assembly_time"] + result["factorisation_time"]
    assert (parts > 0).all()
    assert (parts <= result["cpu_time"]).all()
