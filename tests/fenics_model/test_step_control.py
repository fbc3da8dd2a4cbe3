import pytest

from fenics_model.path.step_control import StepControl


@pytest.fixture
def control():
    return StepControl(size=0.01, smallest=0.001, largest=0.05, target_iterations=6)


def test_a_step_that_takes_the_target_keeps_its_size(control):
    assert control.after_success(6).size == pytest.approx(0.01)


def test_easy_steps_grow_and_hard_ones_shrink(control):
    assert control.after_success(3).size == pytest.approx(0.01 * 2**0.5)
    assert control.after_success(12).size == pytest.approx(0.01 / 2**0.5)


def test_growth_and_shrinking_are_bounded(control):
    assert control.after_success(0).size == pytest.approx(0.02)
    assert control.after_success(100).size == pytest.approx(0.005)
    for _ in range(10):
        control = control.after_success(1)
    assert control.size == 0.05


def test_a_failure_halves_what_was_attempted_until_it_is_too_small(control):
    cut = control.after_failure(0.004)
    assert cut.size == pytest.approx(0.002)
    assert not cut.is_exhausted
    assert cut.after_failure(0.0015).is_exhausted


def test_milestones_are_hit_by_even_steps(control):
    assert control.step_toward(0.03) == pytest.approx(0.01)
    assert control.step_toward(0.025) == pytest.approx(0.025 / 3)
    assert control.step_toward(0.004) == 0.004
