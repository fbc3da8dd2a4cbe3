"""The static solver where the answer is known: a column that buckles, a sheet that grows."""

import numpy as np
import pytest

from bilayer import solve
from bilayer.solvers.path import follow_path
from dshell import HingeSettings
from dshell.energies.assembly import Assembly
from dshell.energies.edge_springs import EdgeSprings
from dshell.energies.hinges import Hinges
from dshell.energies.topology import Topology
from dshell.release.branches import BRANCH_RULES
from dshell.release.specimen_shell import SpecimenShell
from dshell.release.static import StaticPath, StepLimits, equilibrium_solver
from dshell.solve.linear_solver import SuperLUSolver, best_linear_solver
from dshell.solve.newton import Body, EquilibriumSolver, NewtonLimits


@pytest.fixture
def column():
    """Two springs in line, a tenth too short between their held ends."""
    springs = EdgeSprings(np.array([[0, 1], [1, 2]]), np.ones(2), np.ones(2))
    straight = np.array([0, 0, 0, 0.9, 0, 0, 1.8, 0, 0])
    held = [0, 1, 2, 6, 7, 8]
    solver = EquilibriumSolver(Assembly(9, [springs], held), SuperLUSolver())
    return solver, Body([springs], np.zeros(9)), straight


def test_a_compressed_column_has_two_unstable_modes_sideways(column):
    solver, body, straight = column
    assert solver.configure(body, straight).residual == pytest.approx([0, 0, 0], abs=1e-15)
    assert solver.unstable_modes(body, straight) == 2
    direction = solver.unstable_direction(body, straight)
    assert np.abs(direction).max() == pytest.approx(1)
    assert direction[3] == pytest.approx(0, abs=1e-9)


def test_once_pushed_it_settles_where_the_springs_are_at_rest(column):
    solver, body, straight = column
    pushed = straight + 0.01 * solver.unstable_direction(body, straight)
    outcome = solver.find_minimum([body], pushed, NewtonLimits(1e-12, 50, 1.0))
    assert outcome.converged
    assert np.linalg.norm(outcome.state[3:6] - straight[:3]) == pytest.approx(1, abs=1e-9)


class Uphill:
    """A factor whose steps lead uphill, as those of a stiffness that round-off has spoilt."""

    def solve(self, right_side):
        return -right_side


def test_where_the_stiffness_leads_uphill_a_stiffer_one_leads_down(column, monkeypatch):
    solver, body, straight = column
    pushed = straight + 0.01 * solver.unstable_direction(body, straight)
    limits, factor = NewtonLimits(1e-10, 100, 0.1), EquilibriumSolver._factor_convex
    monkeypatch.setattr(EquilibriumSolver, "factor_downhill", lambda self, here: Uphill())
    outcome = solver.find_minimum([body], pushed, limits)
    assert outcome.converged
    assert np.linalg.norm(outcome.state[3:6] - straight[:3]) == pytest.approx(1, abs=1e-8)

    def without_stiffening(self, here, stiffening=0.0):
        return Uphill() if stiffening else factor(self, here)

    monkeypatch.setattr(EquilibriumSolver, "_factor_convex", without_stiffening)
    stuck = solver.find_minimum([body], pushed, limits)
    assert (stuck.converged, stuck.iterations) == (False, 0)


def test_too_few_iterations_are_told(column):
    solver, body, straight = column
    pushed = straight + 0.01 * solver.unstable_direction(body, straight)
    outcome = solver.find_minimum([body], pushed, NewtonLimits(1e-12, 1, 1.0))
    assert (outcome.converged, outcome.iterations) == (False, 1)


def test_plain_steps_balance_the_straight_column_though_it_is_unstable(column):
    solver, body, straight = column
    nearby = straight + 1e-3 * solver.unstable_direction(body, straight)
    outcome = solver.find_nearby_equilibrium(body, nearby, NewtonLimits(1e-12, 10, 1.0))
    assert outcome.converged
    assert outcome.state == pytest.approx(straight, abs=1e-9)
    assert solver.unstable_modes(body, outcome.state) == 2


class NoSearchForModes(SuperLUSolver):
    """Refuses to count negative eigenvalues."""

    def cholesky(self, matrix):
        return SuperLUSolver().cholesky(matrix)

    def factor(self, matrix):
        raise AssertionError("the eigenvalues of a rough shape are nobody's concern")


def test_a_rough_guess_is_smoothed_without_a_search_for_its_modes(column):
    solver, body, straight = column
    pushed = straight + 0.01 * solver.unstable_direction(body, straight)
    limits = NewtonLimits(1e-12, 50, 1.0)
    assert solver.unstable_modes(body, pushed) > 0
    smoothing = EquilibriumSolver(solver.assembly, NoSearchForModes())
    with pytest.raises(AssertionError, match="rough"):
        smoothing.find_minimum([body], pushed, limits)
    smooth = smoothing.smooth_guess(body, pushed, limits)
    assert solver.configure(body, smooth).energy < solver.configure(body, pushed).energy
    assert solver.find_minimum([body], smooth, limits).converged


def test_a_guess_that_is_an_equilibrium_is_kept(column):
    solver, body, straight = column
    smooth = solver.smooth_guess(body, straight, NewtonLimits(1e-12, 50, 1.0))
    assert smooth == pytest.approx(straight, abs=1e-15)


class SoftThenStiff:
    """A spring that is soft up to a length and stiff beyond: one degree of freedom x, E(x)."""

    name = "elastic"
    stencils = (np.array([[0]]),)

    def at(self, state):
        return SoftThenStiffAt(state[0])


class SoftThenStiffAt:
    def __init__(self, x):
        self._x, self._beyond = x, max(x - 1.8, 0)

    def energy(self):
        return np.array([0.25 * self._x**2 + 20 * self._beyond**2])

    def gradient(self):
        return np.array([0.5 * self._x + 40 * self._beyond])

    def hessian(self):
        return [np.array([[[40.5 if self._beyond else 0.5]]])]

    convex_hessian = hessian


def test_a_whole_step_that_comes_too_far_is_halved():
    """To x = 2 the energy falls, but the force grows from 1 to 8 N."""
    pulled = Body([SoftThenStiff()], np.array([1.0]))
    solver = EquilibriumSolver(Assembly(1, pulled.energies), SuperLUSolver())
    outcome = solver.find_minimum([pulled], np.zeros(1), NewtonLimits(1e-9, 1, 100.0))
    assert outcome.residual < 1


@pytest.mark.parametrize("pull", [1.0, 1.005, 1.3])  # 1.005: its cap rounds to less
def test_a_capped_step_is_not_halved(pull):
    """It is short enough already; where shapes wander, halves of it only cost iterations."""
    pulled = Body([SoftThenStiff()], np.array([pull]))
    solver = EquilibriumSolver(Assembly(1, pulled.energies), SuperLUSolver())
    limits = NewtonLimits(1e-9, 1, 1.99, corrections=0)
    capped = solver.find_minimum([pulled], np.zeros(1), limits)
    assert capped.state[0] == pytest.approx(1.99)


class GrownMiddle:
    """A flat lattice whose middle grows: flat it is in equilibrium, and unstable."""

    extra_dofs = fold_count = 0
    extra_flat, fixed_dofs = np.empty(0), np.empty(0, dtype=np.int64)

    def __init__(self, mesh):
        self._mesh = mesh

    def energies(self, stretch):
        topology = Topology.of(self._mesh.triangles)
        ends = self._mesh.points[topology.edges]
        length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        inside = np.linalg.norm(ends.mean(axis=1), axis=1) < 0.02
        count = len(topology.hinges)
        return (
            EdgeSprings(topology.edges, length**2, length * np.where(inside, stretch[0], 1.0)),
            Hinges(topology.hinges, np.full(count, 1e-9), np.zeros(count)),
        )

    def energy_terms(self, stretch, state):
        return {}

    def reference_height(self, stretch):
        return 0.0


@pytest.mark.parametrize(
    ("branch", "is_stable"), [("unstable", False), ("lowest", True), ("other", True)]
)
def test_an_unstable_equilibrium_is_left(coarse_specimen, coarse_mesh, branch, is_stable):
    settings = HingeSettings()
    shell = SpecimenShell(
        coarse_specimen, coarse_mesh, lambda specimen, mesh: GrownMiddle(mesh), settings.tolerance
    )
    equilibria = equilibrium_solver(shell, best_linear_solver())
    limits = StepLimits(settings.tolerance, settings.max_iterations, 0.02, settings.ramp, 0.01)
    rule = BRANCH_RULES[branch](equilibria, shell.escape)
    path = StaticPath(shell, limits, equilibria, rule)
    found = [step.point for step in follow_path(path, [(1.05, 1.05), (1.06, 1.06)])]
    assert [point.unstable_modes == 0 for point in found] == [is_stable, is_stable]
    height = np.ptp(shell.position(found[1].load, found[1].state)[:, 2])
    assert (height > 1e-3) == is_stable


def test_an_equilibrium_counts_its_unstable_modes_once(coarse_specimen, coarse_mesh, monkeypatch):
    counted = []
    count = EquilibriumSolver.unstable_modes

    def counting(solver, body, state):
        counted.append(count(solver, body, state))
        return counted[-1]

    monkeypatch.setattr(EquilibriumSolver, "unstable_modes", counting)
    specimen = coarse_specimen.with_milestones([1.03, 1.05])
    result = solve(specimen, "dshell", HingeSettings(), mesh=coarse_mesh)
    assert result["unstable_modes"].values.tolist() == counted
