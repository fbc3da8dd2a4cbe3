"""Sheets that relax, released by the shell: limits of time, steps, resuming, what is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import bilayer
from bilayer import InputError, MeshSize
from bilayer.results.files import write_result
from bilayer.results.report import result_table
from bilayer.results.table import shape_title
from bilayer.specimen.relaxation import PronySeries
from bilayer.specimen.schedule import Schedule
from bilayer.specimen.toml import parse_specimen, specimen_to_toml
from dshell.release.shell_memory import ShellMemory

SERIES = PronySeries(((0.4, 0.5), (0.3, 20.0)))
R = 0.04


@pytest.fixture(scope="module")
def sheet():
    return replace(bilayer.paper_specimen(), mesh=MeshSize(0.01)).with_milestones([1.06])


@pytest.fixture(scope="module")
def mesh(sheet):
    return bilayer.generate_mesh(sheet)


def relaxing(sheet, times, hold=0.0, layers=("substrate", "kirigami"), **options):
    """The sheet with layers that relax, looked at at some times."""
    for name in layers:
        sheet = sheet.with_layer(name, relaxation=SERIES)
    return replace(sheet, schedule=Schedule(times, hold, **options))


def softened(sheet, name, factor):
    """The sheet with the constants of a layer's law times a factor."""
    law = sheet.layer(name).material
    softer = replace(law, c10=factor * law.c10, c01=factor * law.c01, d1=law.d1 / factor)
    return sheet.with_layer(name, material=softer)


def apart(one, other):
    return np.sqrt(np.mean(np.sum((one - other) ** 2, axis=-1))) / R


def assert_same_stress(one, other):
    """What is remembered is known at Gauss points: in the middle of a layer, near its faces."""
    for level, error in {"bottom": 1e-2, "middle": 1e-5, "top": 1e-2}.items():
        pair = [stress.sel(level=level).values for stress in (one, other)]
        assert np.nanmax(np.abs(pair[0] - pair[1])) < error * np.nanmax(np.abs(pair[1]))


def test_at_time_zero_the_sheet_is_that_of_the_instantaneous_laws(sheet, mesh):
    elastic = bilayer.solve(sheet, "dshell", mesh=mesh)["position"].values[0]
    found = bilayer.solve(relaxing(sheet, (0.0,)), "dshell", mesh=mesh)["position"].values[0]
    assert apart(found, elastic) < 1e-6


def test_after_long_it_is_that_of_the_relaxed_laws(sheet, mesh):
    """Of one layer alone, so that the shape changes."""
    times = (0.0, 1e6)
    slow = relaxing(sheet, times, layers=("substrate",), steps_per_decade=2)
    found = bilayer.solve(slow, "dshell", mesh=mesh)
    soft = bilayer.solve(softened(sheet, "substrate", SERIES.relaxed_share), "dshell", mesh=mesh)
    relaxed = soft["position"].values[0]
    assert apart(found["position"].values[1], relaxed) < 1e-6
    stress, expected = (bilayer.fields(each)["cauchy_stress"] for each in (found, soft))
    assert_same_stress(stress[1], expected[0])
    assert float(np.abs(stress[0] - expected[0]).max()) > 1e3  # Pa
    assert apart(found["position"].values[0], relaxed) > 0.02
    assert found["time"].values.tolist() == [0.0, 1e6]
    assert found["time"].attrs["units"] == "s"


def test_layers_that_relax_alike_keep_the_shape_and_lose_the_stress(sheet, mesh):
    found = bilayer.solve(
        relaxing(sheet, (0.0, 3.0, 100.0), steps_per_decade=3), "dshell", mesh=mesh
    )
    first, *later = found["position"].values
    for shape in later:
        assert apart(shape, first) < 1e-6
    fields = bilayer.fields(found)
    for name in ("cauchy_stress", "pressure"):
        for row, time in zip(fields[name], found["time"].values, strict=True):
            assert_same_stress(row, SERIES.stress_left(time) * fields[name][0])
    energy = fields["energy_density"].values  # of the instantaneous laws
    assert energy[2] == pytest.approx(energy[0], rel=1e-5, nan_ok=True)


def test_a_hold_makes_the_dome_flatter(sheet, mesh):
    heights = [
        float(bilayer.solve(relaxing(sheet, (0.0,), hold), "dshell", mesh=mesh)["height"][0])
        for hold in (0.0, 10.0, 1e4)
    ]
    assert heights[0] > 1.1 * heights[1] > 1.1 * heights[2]


def test_steps_of_time_converge_and_take_few_iterations(sheet, mesh):
    """Their error falls as the square; a step takes fewer iterations than a milestone."""
    found = [
        bilayer.solve(
            relaxing(sheet, (0.0, 5.0), layers=("substrate",), steps_per_decade=count),
            "dshell", mesh=mesh,
        )
        for count in (2, 4, 16)
    ]  # fmt: skip
    shapes = [result["position"].values[1] for result in found]
    coarse, fine = (apart(shape, shapes[2]) for shape in shapes[:2])
    assert fine < 2e-3 and coarse / fine > 3
    late = relaxing(sheet, (5.0,), layers=("substrate",), steps_per_decade=2)
    alone = bilayer.solve(late, "dshell", mesh=mesh)["position"].values[0]
    assert apart(alone, shapes[0]) < 1e-6  # the release at time 0 comes first all the same
    iterations, steps = (found[2][name].values for name in ("iterations", "load_steps"))
    assert iterations[1] / steps[1] <= 1.3 * iterations[0]


def test_an_interrupted_run_goes_on_with_its_memory(sheet, mesh, tmp_path, monkeypatch):
    timed = relaxing(sheet, (0.0, 1.0, 10.0), hold=2.0, layers=("substrate",), steps_per_decade=3)
    whole = bilayer.solve(timed, "dshell", mesh=mesh)
    file = tmp_path / "run.nc"

    def stop(step):
        if step.ends_target and step.index == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        bilayer.solve(timed, "dshell", mesh=mesh, observers=[stop], output=file)
    resumed = bilayer.solve(timed, "dshell", mesh=mesh, resume=file)
    assert np.array_equal(resumed["position"].values, whole["position"].values)
    other = tmp_path / "earlier.nc"
    with monkeypatch.context() as patched:  # an earlier version remembered other numbers
        save = ShellMemory.save
        patched.setattr(
            ShellMemory,
            "save",
            lambda memory: {
                name: values[..., :1] if values.ndim else values
                for name, values in save(memory).items()
            },
        )
        with pytest.raises(KeyboardInterrupt):
            bilayer.solve(timed, "dshell", mesh=mesh, observers=[stop], output=other)
    with pytest.raises(InputError, match="the memory of substrate has the shape"):
        bilayer.solve(timed, "dshell", mesh=mesh, resume=other)


def test_a_file_keeps_the_schedule_and_results_are_computed_again(sheet, mesh, tmp_path):
    timed = relaxing(sheet, (0.0, 2.0), hold=1.0, steps_per_decade=3)
    assert parse_specimen(specimen_to_toml(timed)) == timed
    write_result(bilayer.solve(timed, "dshell", mesh=mesh), tmp_path / "a.nc")
    result = bilayer.open_result(tmp_path / "a.nc")
    from bilayer.solvers.rerun import agree, rerun

    assert agree(result, rerun(result))
    head, units, first, second = result_table(result).splitlines()
    assert (head.split()[1], units.split()[1]) == ("after", "s")
    assert [line.split()[1] for line in (first, second)] == ["0", "2"]
    titles = [shape_title(result.isel(prestretch=k)) for k in range(2)]
    assert titles == ["λ = 1.06, 0 s", "λ = 1.06, 2 s"]


def test_times_in_a_file_have_units(sheet):
    text = specimen_to_toml(relaxing(sheet, (0.0, 60.0), hold=120.0))
    text = text.replace("milestones = [\n    0.0,\n    60.0,\n]", 'milestones = ["0 s", "1 min"]')
    text = text.replace("hold = 120.0", 'hold = "2 min"')
    assert parse_specimen(text).schedule == Schedule((0.0, 60.0), 120.0)


@pytest.mark.parametrize(
    ("times", "message"),
    [([], "at least one time"), ([1.0, 1.0], "times that rise"), ([-1.0], "milestones = -1")],
)
def test_bad_times_are_refused(times, message):
    with pytest.raises(InputError, match=message):
        Schedule(tuple(times))


def test_who_takes_no_steps_of_time_says_so(sheet, mesh):
    timed = relaxing(sheet, (0.0,))
    with pytest.raises(InputError, match=r"\[time\]: .* takes no steps of time"):
        bilayer.solve(timed, "dshell", bilayer.HingeSettings(), mesh=mesh)
    with pytest.raises(InputError, match="expected a single one"):
        replace(timed, prestretch=replace(timed.prestretch, milestones=(1.03, 1.06)))


def test_the_example_rises_for_minutes():
    path = Path(__file__).parents[2] / "examples" / "slow_dome.toml"
    specimen = bilayer.read_specimen(path, ["mesh.size=0.01"])
    heights = bilayer.solve(specimen, "dshell")["height"].values
    assert 1e3 * heights == pytest.approx([8.20, 10.27, 13.36, 15.38, 16.49], abs=0.1)
