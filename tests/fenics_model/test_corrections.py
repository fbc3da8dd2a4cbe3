"""Corrections that share a factor: their acceleration, when they end, and what they come to."""

import numpy as np
import pytest

pytest.importorskip("dolfinx")

from verification.buckled_plate import BuckledPlate
from verification.solid_problem import newton_of

from fenics_model.solid.state import State
from fenics_model.solve.corrections import AndersonMixing, CorrectionRule, Progress
from fenics_model.solve.newton import Iterate


def test_a_linear_system_takes_one_correction_more_than_it_has_distinct_errors():
    """With five distinct eigenvalues of K^-1 A, it takes six; without acceleration it diverges."""
    rng = np.random.default_rng(3)
    turned = np.linalg.qr(rng.normal(size=(12, 12)))[0]
    matrix = (
        turned @ np.diag([0.1, 0.5, 1.0, 2.5, 9.0, 9.0, 9.0, 1.0, 1.0, 0.5, 0.1, 0.1]) @ turned.T
    )
    solution = rng.normal(size=12)
    mixing = AndersonMixing(np.dot, history=8)
    state, plain = State(np.zeros(12)), np.zeros(12)
    for _ in range(6):
        state += mixing.step(state, matrix @ (state.values - solution))
        plain -= matrix @ (plain - solution)
    assert state.values == pytest.approx(solution, abs=1e-6)
    assert np.abs(plain - solution).max() > 1e3


def test_only_the_last_changes_are_kept():
    """With a history of one it is the secant method along a line, and forgets the rest."""
    mixing = AndersonMixing(np.dot, history=1)
    rate = np.array([0.2, 3.0, 5.0])
    state = State(np.ones(3))
    for _ in range(4):
        state += mixing.step(state, rate * state.values)
    assert np.abs(state.values).max() > 1e-3


@pytest.mark.parametrize(("rate", "is_slow"), [(0.01, False), (0.3, False), (0.9, True)])
def test_a_new_factor_is_due_when_the_rest_would_cost_more(rate, is_slow):
    progress = Progress(CorrectionRule(tangent_cost=20.0), 1.0, 1e-8)
    for k in range(1, 4):
        progress.note(rate**k)
    assert progress.is_slow == is_slow


def test_next_to_the_end_no_factor_is_due_however_slow_it_is():
    progress = Progress(CorrectionRule(tangent_cost=20.0), 1.0, 0.5)
    for norm in (0.9, 0.8, 0.7):
        progress.note(norm)
    assert not progress.is_slow


@pytest.fixture
def plate():
    plate = BuckledPlate(compression=0.99)
    yield plate
    plate.close()


def test_fewer_tangents_come_to_the_same_state(plate):
    guess = plate.flat + plate.lift(2e-4)
    each = CorrectionRule(fewest=0, most=0)  # a new tangent for each correction: Newton's method
    with newton_of(plate.solid, plate.newton.held, rule=each) as newton:
        newtons = newton.solve(guess, plate.tolerance)
    kept = plate.newton.solve(guess, plate.tolerance)
    assert newtons.converged
    assert kept.converged
    assert newtons.corrections == newtons.iterations
    assert kept.iterations < newtons.iterations
    assert kept.state.values == pytest.approx(newtons.state.values, abs=1e-12)


def test_the_factors_of_one_state_serve_the_next(plate):
    """A state near by takes no tangent of its own, and comes to the same."""
    guess = plate.flat + plate.lift(1e-6)
    outcome = plate.newton.solve(guess, plate.tolerance, plate.newton.factorise(plate.flat))
    assert outcome.converged
    assert outcome.iterations == 0
    assert outcome.corrections > 0
    assert outcome.state.values == pytest.approx(plate.flat.values, abs=1e-12)


def test_a_step_that_turns_elements_inside_out_is_shortened_until_it_does_not(plate):
    """One and a half times the height off, the plate is its mirror image; half of that is not."""
    turned_over = plate.solid.interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], -1.5 * x[2]]))
    step = turned_over.values
    with newton_of(plate.solid, []) as newton:
        begin = Iterate.begin(newton, plate.solid.undeformed)
        assert not np.isfinite(newton.residual_norm(plate.solid.undeformed + step))
        there = begin.moved(step, halvings=1)
        assert there.state - begin.state == pytest.approx(step / 2)
        assert np.isfinite(there.norm)
        assert begin.moved(8 * step, halvings=2) is None


def test_what_stays_inside_out_has_not_converged(plate):
    turned_over = plate.solid.interpolate(lambda x: np.stack([0 * x[0], 0 * x[0], -1.5 * x[2]]))
    outcome = plate.newton.solve(turned_over, plate.tolerance)
    assert not outcome.converged
    assert outcome.reason == "an element was turned inside out"
