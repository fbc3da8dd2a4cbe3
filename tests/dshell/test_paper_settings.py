import dataclasses

import pytest

from bilayer import InputError
from dshell import PaperSettings


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"thickness": "natual"}, "solver.thickness = 'natual': expected one of.*'natural'"),
        ({"total_time": 0.0}, "solver.total_time = 0.0 s: expected a number greater than 0"),
        ({"time_step": -1.0}, "solver.time_step = -1.0 s: expected a number greater than 0"),
        ({"time_step": 2.0, "total_time": 1.0}, "solver.time_step = 2.0 s: expected at most"),
        ({"gravity": -9.81}, "solver.gravity = -9.81 m/s2: expected a number of at least 0"),
        ({"damping_rate": float("nan")}, "solver.damping_rate = nan: expected a finite number"),
        ({"tolerance": 0.0}, "solver.tolerance = 0.0: expected a number greater than 0"),
        ({"max_iterations": 0}, "solver.max_iterations = 0: expected a whole number"),
    ],
)
def test_bad_values_are_named(values, message):
    with pytest.raises(InputError, match=message):
        PaperSettings(**values)


def test_every_setting_is_documented():
    assert all(field.metadata["text"] for field in dataclasses.fields(PaperSettings))


@pytest.mark.parametrize(("total", "step", "steps"), [(1.0, 0.25, 4), (1.0, 0.3, 4), (1.0, 1.0, 1)])
def test_steps_are_never_longer_than_asked(total, step, steps):
    assert PaperSettings(total_time=total, time_step=step).steps == steps
