"""A specimen's path: down again, kept and restored, linearised; on any number of ranks."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from bilayer import InputError, MeshSize, generate_mesh, paper_specimen
from bilayer.solvers.parameters import changed, parameter_scale
from bilayer.solvers.path import follow_path
from bilayer.solvers.run import solve_with
from fenics_model import SOLVER, SolidSettings

COARSE = replace(paper_specimen(), mesh=MeshSize(0.016), gravity=0.2)
TARGETS = [(1.02, 1.02), (1.03, 1.03), (1.02, 1.02), (1.02, 1.02), (1.03, 1.02)]
MESH = generate_mesh(COARSE)


def open_path(specimen=COARSE, start=None):
    return closing(
        SOLVER.open_path(
            specimen, SolidSettings(), mesh=MESH, start=start, comm=None, progress=None
        )
    )


def sharp_position(point, specimen=COARSE):
    """The shape after one more step of Newton's method.

    The accelerated corrections stop as soon as the tolerance is met, and what is left of a residual
    is more than two runs may differ by.
    """
    here = point.linearised()
    residual = here._residual(specimen, point.stretch)
    return point.position + here.position_change(-here.solve(residual))


def at_targets(path, targets, first=0):
    """The state at each target, while the path is there."""
    for step in follow_path(path, targets, first=first):
        assert step.failure is None
        if step.is_at_target:
            yield step


@pytest.fixture(scope="module")
def visited():
    """The shape, the effort and what is saved at each target."""
    with open_path() as path:
        return [
            (sharp_position(step.point), step.effort, step.point.save())
            for step in at_targets(path, TARGETS)
        ]


@pytest.mark.mpi
def test_the_way_down_leads_back_to_the_shape(visited):
    (first, _, _), (second, effort, _), (again, down, _), (same, none, _), _ = visited
    assert np.abs(second - first).max() > 1e-3
    assert again == pytest.approx(first, abs=1e-7 * COARSE.characteristic_length)
    assert down.iterations < effort.iterations
    assert same == pytest.approx(again, abs=1e-12)
    assert none.iterations <= 1


@pytest.mark.mpi
def test_a_path_that_is_left_goes_on_where_it_is():
    """Half of the way to a target, then to another: the shape is that of the other."""
    with open_path() as path:
        next(path.approach((1.03, 1.03)))
        (there,) = at_targets(path, TARGETS[:1])
        shape = there.point.position
    with open_path() as path:
        (straight,) = at_targets(path, TARGETS[:1])
        assert shape == pytest.approx(straight.point.position, abs=1e-9)


@pytest.mark.mpi
@pytest.mark.parametrize("done", [1, 2, 4])
def test_a_restored_path_goes_on_as_if_it_had_never_been_left(visited, done):
    from mpi4py import MPI

    with open_path() as path:
        path.restore(visited[done - 1][2])
        for step, (shape, effort, _) in zip(
            at_targets(path, TARGETS, first=done), visited[done:], strict=True
        ):
            assert sharp_position(step.point) == pytest.approx(shape, abs=1e-12)
            # the factors of several ranks differ by round-off from run to run, and a few of the
            # accelerated corrections with them
            apart = 0 if MPI.COMM_WORLD.size == 1 else 0.1 * effort.iterations
            assert abs(step.effort.iterations - effort.iterations) <= apart


@pytest.mark.mpi
def test_what_is_saved_does_not_depend_on_the_ranks(visited):
    from mpi4py import MPI

    if MPI.COMM_WORLD.size == 1:
        pytest.skip("one rank: run under mpirun -n 2")
    alone = SOLVER.open_path(
        COARSE, SolidSettings(), mesh=MESH, start=None, comm=MPI.COMM_SELF, progress=None
    )
    with closing(alone):
        alone.restore(visited[0][2])
        (there,) = at_targets(alone, TARGETS[:2], first=1)
        assert there.point.position == pytest.approx(visited[1][0], abs=1e-9)


def test_the_shapes_of_a_start_are_kept_with_the_path():
    specimen = COARSE.with_milestones([1.02, 1.03])
    start = solve_with(SOLVER, specimen, SolidSettings(), mesh=MESH)
    with open_path(specimen, start) as path:
        steps = at_targets(path, TARGETS[:2])
        saved = next(steps).point.save()
        whole = next(steps)
        expected, guided, text = whole.point.position, whole.effort.guided_steps, path.start
    assert guided > 0
    with open_path(specimen) as path:
        path.restore(saved)
        (there,) = at_targets(path, TARGETS[:2], first=1)
        assert there.point.position == pytest.approx(expected, abs=1e-12)
        assert there.effort.guided_steps == guided
        assert path.start == text


PARAMETERS = {
    "prestretch": 1e-5,
    "prestretch.y": 1e-5,
    "gravity": 1e-5,
    "substrate.thickness": 1e-5,
    "kirigami.thickness": 1e-5,
    "kirigami.density": 1e-5,
    "substrate.material.c01": 1e-5,
}
"""And how well the derivative agrees with equilibria that are computed anew."""


@pytest.fixture(scope="module")
def derivatives():
    """By parameter the derivative of the position, and that of a number by the adjoint."""
    weights = np.random.default_rng(4).normal(size=(len(MESH.points), 3))
    found = {}
    with open_path() as path:
        (step,) = at_targets(path, TARGETS[:1])
        saved, here = step.point.save(), step.point.linearised()
        adjoint = here.solve(here.state_gradient(weights))
        for parameter in PARAMETERS:
            residual = here.residual_by(parameter)
            fixed = here.position_by(parameter)
            position = fixed + here.position_change(-here.solve(residual))
            found[parameter] = position, np.sum(weights * fixed) - adjoint @ residual
        with pytest.raises(InputError, match="parameter = 'bond'"):
            here.position_by("bond")
        again = step.point.linearised().residual_by("prestretch")
        first = open_again(saved, "prestretch")
        assert again == pytest.approx(first, abs=1e-9 * np.abs(first).max())  # nothing is changed
    return found, weights, saved


def open_again(saved, parameter):
    """The derivative of the residual on a path that has seen no other parameter."""
    with open_path() as path:
        path.restore(saved)
        return path.stopped().linearised().residual_by(parameter)


@pytest.mark.mpi
@pytest.mark.parametrize("parameter", PARAMETERS)
def test_a_derivative_is_that_of_the_equilibria(derivatives, parameter):
    found, weights, saved = derivatives
    step = 2e-5 * parameter_scale(COARSE, TARGETS[0], parameter)
    positions = []
    for sign in (1, -1):
        specimen, stretch = changed(COARSE, TARGETS[0], parameter, sign * step)
        with open_path(specimen) as path:
            path.restore(saved)
            (there,) = at_targets(path, [stretch])
            positions.append(sharp_position(there.point, specimen))
    difference = (positions[0] - positions[1]) / (2 * step)
    position, number = found[parameter]
    size = np.abs(difference).max()
    assert position == pytest.approx(difference, abs=PARAMETERS[parameter] * size)
    assert number == pytest.approx(np.sum(weights * position), rel=1e-8)
