"""Steps guided by the shapes of the accurate shell, against load stepping alone."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from bilayer import (
    ComputationError,
    InputError,
    MeshSize,
    generate_mesh,
    paper_specimen,
    solve,
)
from bilayer.results.report import provenance
from bilayer.results.start_shapes import StartShapes
from bilayer.results.starting import LONGEST_WAY, with_waypoints
from bilayer.solvers.run import solve_with
from fenics_model import SOLVER, SolidSettings

COARSE = replace(paper_specimen(), mesh=MeshSize(0.009))

needs_dolfinx = pytest.mark.skipif(find_spec("dolfinx") is None, reason="dolfinx is not there")


@pytest.fixture(scope="module")
def mesh():
    return generate_mesh(COARSE)


@pytest.fixture(scope="module")
def shell(mesh):
    return solve(COARSE.with_milestones([1.03, 1.06, 1.1]), "dshell", mesh=mesh)


@pytest.fixture(scope="module")
def stepped(mesh):
    return solve(COARSE.with_milestones([1.03, 1.06]), "fenics", mesh=mesh, start="flat")


def test_waypoints_stand_where_milestones_are_far_apart():
    pairs = with_waypoints(COARSE.with_milestones([1.03, (1.15, 1.03)])).prestretch.milestones
    assert pairs[0] == (1.03, 1.03)
    assert pairs[-1] == (1.15, 1.03)
    assert np.diff(pairs, axis=0).max() <= LONGEST_WAY + 1e-12
    assert len(pairs) == 3


def test_shapes_are_found_at_and_between_targets(shell, mesh):
    shapes = StartShapes.of(shell, mesh)
    found = shapes.take_shapes((1.0, 1.0), (1.06, 1.06))
    assert [shape.remaining for shape in found] == pytest.approx([0.03, 0.0])
    assert found[1].shape == pytest.approx(shell["position"].values[1])
    (last,) = shapes.take_shapes((1.06, 1.06), (1.2, 1.2))
    assert last.remaining == pytest.approx(0.1)
    assert shapes.take_shapes((1.2, 1.2), (1.2, 1.3)) == []


def test_the_nearest_shape_stands_in(shell, mesh):
    shapes = StartShapes.of(shell, mesh)
    assert shapes.take_shapes((1.0, 1.0), (1.01, 1.02)) == []
    first = shapes.take_nearest((1.01, 1.02))
    assert first.remaining == 0
    assert first.shape == pytest.approx(shell["position"].values[0])


def test_a_shape_that_comes_again_is_taken_in_its_turn():
    """Up, down, and up by the same prestretches: five shapes, each one's height its number."""
    stretches = np.array([[1.03] * 2, [1.06] * 2, [1.03] * 2, [1.0] * 2, [1.03] * 2])
    shapes = StartShapes(stretches, np.arange(5.0)[:, None, None] * np.ones((5, 1, 3)))
    ways = [(1.0, 1.03), (1.03, 1.06), (1.06, 1.03), (1.03, 1.0), (1.0, 1.03)]
    taken = [
        [int(s.shape[0, 0]) for s in shapes.take_shapes((begin,) * 2, (end,) * 2)]
        for begin, end in ways
    ]
    assert taken == [[0], [1], [2], [3], [4]]


@needs_dolfinx
def test_the_shell_leads_to_what_load_stepping_finds(shell, stepped, mesh):
    led = solve(COARSE.with_milestones([1.03, 1.06]), "fenics", mesh=mesh)
    radius = COARSE.characteristic_length
    assert led["position"].values == pytest.approx(stepped["position"].values, abs=1e-8 * radius)
    assert led["unstable_modes"].values.tolist() == stepped["unstable_modes"].values.tolist()
    assert led["guided_steps"].values.tolist() == led["load_steps"].values.tolist() == [1, 1]
    assert led["iterations"].values[0] <= 8
    assert 2 * led["iterations"].sum() < stepped["iterations"].sum()
    assert "dshell, model morley" in led.attrs["start"]
    assert "not followed" not in led.attrs["start"]
    assert stepped.attrs["start"] == "flat"
    assert stepped["guided_steps"].values.tolist() == [0, 0]


@needs_dolfinx
def test_straight_to_a_milestone_in_few_iterations(stepped, mesh):
    led = solve(COARSE.with_milestones([1.06]), "fenics", mesh=mesh)
    assert led["position"].values[0] == pytest.approx(stepped["position"].values[1], abs=1e-9)
    assert led["iterations"].values[0] <= 12


@needs_dolfinx
def test_from_a_shape_on_another_branch_the_disc_flows(shell, stepped, mesh):
    """The mirror image bends the wrong way; from there the disc snaps."""
    mirrored = shell.copy(deep=True)
    mirrored["position"] = mirrored["position"] * [1, 1, -1]
    led = solve(COARSE.with_milestones([1.03]), "fenics", mesh=mesh, start=mirrored)
    assert led["position"].values[0] == pytest.approx(stepped["position"].values[0], abs=1e-9)
    assert led["stabilised_steps"].values[0] > 0
    assert led["dissipated_energy"].values[0] > 0
    assert led["load_steps"].values[0] == 1


@needs_dolfinx
def test_behind_a_shape_on_another_branch_the_next_one_leads_by_itself(shell, stepped, mesh):
    """Its defect would make the next guess a mirror image of what is wanted."""
    mirrored = shell.copy(deep=True)
    mirrored["position"][0] *= [1, 1, -1]
    led = solve(COARSE.with_milestones([1.03, 1.06]), "fenics", mesh=mesh, start=mirrored)
    assert led["position"].values == pytest.approx(stepped["position"].values, abs=1e-9)
    first, second = led["stabilised_steps"].values
    assert first > 0 == second
    assert led["iterations"].values[1] <= 12


@needs_dolfinx
def test_where_a_shape_is_inside_out_the_disc_flows_from_where_it_is(shell, stepped, mesh):
    """No state can be made of crumpled paper; nothing is left for load steps."""
    crumpled = shell.copy(deep=True)
    rng = np.random.default_rng(0)
    crumpled["position"] += rng.normal(scale=4e-3, size=crumpled["position"].shape)
    led = solve(COARSE.with_milestones([1.03]), "fenics", mesh=mesh, start=crumpled)
    assert led["position"].values[0] == pytest.approx(stepped["position"].values[0], abs=1e-9)
    assert led["stabilised_steps"].values[0] > 0
    assert led["load_steps"].values[0] == 1
    assert "not followed" not in led.attrs["start"]


@needs_dolfinx
def test_a_shape_that_leads_nowhere_is_followed_by_load_steps(shell, stepped, mesh):
    """Without the flow a mirror image leads nowhere; the result says so."""
    mirrored = shell.copy(deep=True)
    mirrored["position"] = mirrored["position"] * [1, 1, -1]
    settings = SolidSettings(flow_steps=0)
    led = solve(COARSE.with_milestones([1.03]), "fenics", settings, mesh=mesh, start=mirrored)
    assert led["position"].values[0] == pytest.approx(stepped["position"].values[0], abs=1e-9)
    assert led["load_steps"].values[0] > 1
    assert "; not followed to 1.03 (" in led.attrs["start"]
    assert "not followed to 1.03" in provenance(led)


@needs_dolfinx
def test_without_a_shell_the_load_is_stepped_and_the_result_says_why(stepped, mesh):
    def failing(mesh):
        raise ComputationError("the shell stopped at prestretch 1")

    specimen = COARSE.with_milestones([1.03])
    result = solve_with(SOLVER, specimen, SolidSettings(), mesh=mesh, start=failing)
    assert result.attrs["start"] == "flat, because the shell stopped at prestretch 1"
    assert result["position"].values[0] == pytest.approx(stepped["position"].values[0], abs=1e-9)


def test_the_shell_does_not_start_from_the_shell(mesh):
    with pytest.raises(InputError, match="start = 'shell'"):
        solve(COARSE, "dshell", mesh=mesh, start="shell")
    with pytest.raises(InputError, match="start"):
        solve(COARSE, "fenics", mesh=mesh, start="flatt")


@needs_dolfinx
@pytest.mark.parametrize("further", [0, 3])
def test_a_flow_goes_on_where_no_load_step_leads(shell, stepped, mesh, monkeypatch, further):
    """From the mirror image the first flow gets two steps, and load steps are made to fail."""
    from fenics_model.path import continuation, guide

    rule = guide.GuideRule(iteration_limit=1, flow_steps=2, further_flows=further)

    def fail(self, there, accepted, reference):
        self.control = replace(self.control, size=0.0)
        return replace(
            self._newton.solve(self.predictor.last, np.inf), converged=False, reason="no"
        )

    mirrored = shell.copy(deep=True)
    mirrored["position"] = mirrored["position"] * [1, 1, -1]
    monkeypatch.setattr(guide, "GuideRule", lambda: rule)
    monkeypatch.setattr(continuation.Continuation, "_take_load_step", fail)
    led = solve(COARSE.with_milestones([1.03]), "fenics", mesh=mesh, start=mirrored)
    assert led["converged"].values.tolist() == [int(further > 0)]
    assert "; not followed to 1.03 (" in led.attrs["start"]
    if further:
        assert led["position"].values[0] == pytest.approx(stepped["position"].values[0], abs=1e-9)
        assert led["unstable_modes"].values.tolist() == [0]
    else:
        assert "no convergence (no)" in led.attrs["stop_reason"]
