"""A release in time ends where the static solver's does, and says so where it does not."""

import numpy as np
import pytest

from bilayer import InputError, solve
from bilayer.errors import ComputationError
from bilayer.geometry.alignment import rms_distance
from dshell import HingeSettings, MorleySettings
from dshell.models.hinge import HingeModel
from dshell.models.morley import MorleyModel
from dshell.release.branches import NextEquilibriumRule
from dshell.release.dynamic import DynamicPath, MotionLimits
from dshell.release.specimen_shell import SpecimenShell
from dshell.release.static import StepLimits, equilibrium_solver
from dshell.solve.linear_solver import best_linear_solver

KINDS = pytest.mark.parametrize("kind", [MorleySettings, HingeSettings])


@KINDS
def test_it_comes_to_rest_in_the_static_equilibrium(kind, coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.03, 1.06])
    still, moved = (
        solve(specimen, "dshell", kind(method=method, tolerance=1e-10), mesh=coarse_mesh)
        for method in ("static", "dynamic")
    )
    assert moved.converged.values.tolist() == [1, 1]
    assert moved.unstable_modes.values.tolist() == [0, 0]
    weights = np.ones(len(coarse_mesh.points))
    for one, other in zip(still.position.values, moved.position.values, strict=True):
        assert rms_distance(one, other, weights) < 1e-6 * specimen.characteristic_length


@KINDS
def test_what_still_moves_at_the_end_is_no_equilibrium(kind, coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.03, 1.06])
    settings = kind(method="dynamic", total_time=0.02, time_step=0.01)
    result = solve(specimen, "dshell", settings, mesh=coarse_mesh)
    assert result.converged.values.tolist() == [0, 0]
    assert "the body still moves after solver.total_time = 0.02 s" in result.attrs["stop_reason"]
    assert np.isfinite(result.last_position.values[0]).all()


@KINDS
def test_drag_slows_the_motion(kind, coarse_specimen, coarse_mesh):
    specimen = coarse_specimen.with_milestones([1.03])
    times = {"method": "dynamic", "total_time": 0.1, "time_step": 0.01}
    free, slow = (
        solve(specimen, "dshell", kind(damping_rate=rate, **times), mesh=coarse_mesh)
        for rate in (0.0, 1e5)
    )
    risen = [np.ptp(result.last_position.values[0, :, 2]) for result in (free, slow)]
    assert risen[1] < 0.5 * risen[0]


@KINDS
@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"method": "dynamics"}, "solver.method = 'dynamics': expected one of 'static', 'dynamic'"),
        ({"time_step": 0.0}, "solver.time_step = 0.0 s: expected a number greater than 0"),
        ({"time_step": -1.0}, "solver.time_step = -1.0 s: expected a number greater than 0"),
        ({"time_step": 30.0}, "solver.time_step = 30.0 s: expected at most solver.total_time"),
        ({"time_step": 1e-25}, "solver.time_step = 1e-25 s: expected at most"),
        ({"time_step": 1e-300}, "solver.time_step = 1e-300 s: expected a number of at least"),
        ({"damping_rate": -1.0}, "solver.damping_rate = -1.0 1/s: expected a number of at least 0"),
    ],
)
def test_bad_times_are_named(kind, values, message):
    with pytest.raises(InputError, match=message):
        kind(**values)


@KINDS
def test_where_it_diverges_what_was_reached_is_kept(kind, coarse_specimen, coarse_mesh):
    """No prestretch needs no iteration; more than that needs more than is allowed here."""
    specimen = coarse_specimen.with_milestones([1.0, 1.06])
    settings = kind(max_iterations=1, smallest_step=0.2)
    result = solve(specimen, "dshell", settings, mesh=coarse_mesh)
    assert result.converged.values.tolist() == [1, 0]
    assert np.isfinite(result.position.values[0]).all()
    assert np.isfinite(result.last_position.values[1]).all()
    assert result.attrs["stop_reason"].startswith("stopped at prestretch 1: Newton")


@pytest.mark.parametrize("model", [lambda *case: MorleyModel(*case, MorleySettings()), HingeModel])
def test_a_motion_that_diverges_keeps_what_was_reached(model, coarse_specimen, coarse_mesh):
    shell = SpecimenShell(coarse_specimen, coarse_mesh, model, 1e-8)
    solver = equilibrium_solver(shell, best_linear_solver())
    motion = MotionLimits(20.0, 0.01, 10.0, iterations=0)
    limits = StepLimits(1e-8, 200, 0.02)
    path = DynamicPath(shell, motion, limits, solver, NextEquilibriumRule(solver))
    (still,) = [state for state in path.approach((1.0, 1.0)) if state.share == 1]
    with pytest.raises(ComputationError, match="Newton"):
        list(path.approach((1.06, 1.06)))
    assert path.stopped().state == pytest.approx(still.state, abs=1e-12)
