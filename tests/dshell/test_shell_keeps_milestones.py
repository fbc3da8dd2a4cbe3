"""Each milestone is in the file when it is reached, whatever happens after; a run goes on from it.

The milestones go up, down again, and up by another way, so the path's state is what counts.
"""

import multiprocessing
import random
import signal
import time

import killed_runs
import numpy as np
import pytest
from numpy.linalg import LinAlgError

import bilayer
from bilayer import HingeSettings, InputError, MorleySettings, open_result, solve
from bilayer.cli.main import main
from bilayer.errors import Interrupted
from bilayer.results import files
from bilayer.results.files import open_resume_point
from bilayer.runtime import output_file, version
from bilayer.solvers import recording
from bilayer.specimen.toml import specimen_to_toml
from dshell.release import coarse_start
from dshell.release.specimen_path import ShellPath

KILLS = 10
COUNT = len(killed_runs.MILESTONES)


@pytest.fixture(scope="module")
def processes():
    """Processes that have everything loaded, to be killed."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["killed_runs", "dshell", "bilayer.solvers.registry"])
    return context


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory, processes):
    """The file of the whole run, and the seconds that it took."""
    folder = tmp_path_factory.mktemp("undisturbed")
    output, log = folder / "run.nc", folder / "log"
    process = processes.Process(target=killed_runs.compute, args=(output, log, False))
    process.start()
    process.join(120)
    assert process.exitcode == 0
    times = [float(line.split()[1]) for line in log.read_text().splitlines()]
    return open_result(output), times[-1] - times[0]


def assert_same_numbers(result, expected):
    for name, variable in expected.data_vars.items():
        if variable.dtype.kind in "fi" and variable.attrs.get("units") != "s":
            np.testing.assert_allclose(result[name], variable, rtol=1e-9, atol=1e-14, err_msg=name)
    assert result.attrs["stop_reason"] == ""


@pytest.mark.slow
def test_a_run_killed_at_any_moment_has_its_milestones_and_goes_on(
    tmp_path, processes, undisturbed
):
    expected, seconds = undisturbed
    moments, kept_by = random.Random(13), []
    for kill in range(KILLS):
        output, log = tmp_path / f"{kill}.nc", tmp_path / f"{kill}.log"
        process = processes.Process(target=killed_runs.compute, args=(output, log, False))
        process.start()
        while not (log.exists() and log.read_text()):
            time.sleep(0.001)
        time.sleep(moments.uniform(0, seconds))
        process.kill()
        process.join()
        reached = killed_runs.noted(log)
        kept = 0
        if output.exists():
            found = open_result(output)
            kept = int(found["converged"].sum())
            assert found["converged"].values.tolist() == [1] * kept + [0] * (COUNT - kept)
            assert found["position"].values[:kept] == pytest.approx(
                expected["position"].values[:kept], rel=1e-9, abs=1e-14
            )
            assert found.attrs["stop_reason"] == ("" if kept == COUNT else "interrupted")
        assert len(reached) <= kept <= len(reached) + 1
        kept_by.append(kept)
        resume = output if output.exists() else None
        again = solve(
            killed_runs.specimen(), "dshell", MorleySettings(), output=output, resume=resume
        )
        assert_same_numbers(again, expected)
        assert_same_numbers(open_result(output), expected)
    assert len(set(kept_by)) > 2, "the moments are spread over the run"


def test_a_finished_file_has_nothing_to_go_on_with(undisturbed, tmp_path):
    expected, _ = undisturbed
    bilayer.write_result(expected, tmp_path / "run.nc")
    assert open_resume_point(tmp_path / "run.nc") is None
    again = solve(killed_runs.specimen(), "dshell", resume=tmp_path / "run.nc")
    assert again.identical(open_result(tmp_path / "run.nc"))


@pytest.fixture
def coarse(coarse_specimen):
    return coarse_specimen.with_milestones([1.01, 1.02, 1.03, 1.04])


def solved(specimen, mesh, output, **options):
    return solve(specimen, "dshell", HingeSettings(), mesh=mesh, output=output, **options)


def failing_at(number, error):
    """Return a function that raises an error when it is called for the n-th time."""
    calls = []

    def fail(*args, **options):
        calls.append(args)
        if len(calls) == number:
            raise error

    return fail


@pytest.mark.parametrize("error", [MemoryError("no more"), TypeError("a fault")])
def test_an_error_in_the_third_milestone_keeps_two(
    coarse, coarse_mesh, tmp_path, monkeypatch, error
):
    follow, fail = ShellPath.approach, failing_at(3, error)

    def approach(path, target):
        fail()
        yield from follow(path, target)

    monkeypatch.setattr(ShellPath, "approach", approach)
    output = tmp_path / "run.nc"
    if isinstance(error, MemoryError):
        result = solved(coarse, coarse_mesh, output)
        assert result.attrs["stop_reason"] == "stopped at prestretch 1.02: MemoryError: no more"
    else:
        with pytest.raises(TypeError, match="a fault"):
            solved(coarse, coarse_mesh, output)
    monkeypatch.undo()
    kept = open_result(output)
    assert kept["converged"].values.tolist() == [1, 1, 0, 0]
    assert np.isfinite(kept["height"].values[:2]).all()


def test_a_measure_that_fails_loses_no_shape(coarse, coarse_mesh, tmp_path, monkeypatch, capsys):
    measure, fail = recording.measure, failing_at(2, LinAlgError("SVD did not converge"))

    def measured(*args):
        fail()
        return measure(*args)

    monkeypatch.setattr(recording, "measure", measured)
    (tmp_path / "s.toml").write_text(specimen_to_toml(coarse))
    words = [str(tmp_path / "s.toml"), "--solver", "dshell", "--model", "hinge", "--quiet"]
    assert main(["solve", *words, "-o", str(tmp_path / "run.nc")]) == 0
    told = "1.02: LinAlgError: SVD did not converge"
    assert capsys.readouterr().err == f"bilayer: not measured: {told}\n"
    kept = open_result(tmp_path / "run.nc")
    assert kept["converged"].values.all()
    assert np.isfinite(kept["position"].values).all()
    assert np.isnan(kept["height"].values).tolist() == [False, True, False, False]
    assert kept.attrs["not_measured"] == told
    assert main(["info", str(tmp_path / "run.nc")]) == 0
    assert f"unmeasured  {told}" in capsys.readouterr().out


def signal_in(monkeypatch, place, number, at_call):
    """Send this process a signal when a place of the program is passed for the n-th time."""
    module, name = place
    usual, calls = getattr(module, name), []

    def interrupted(*args, **options):
        calls.append(args)
        if len(calls) == at_call:
            signal.raise_signal(number)
        return usual(*args, **options)

    monkeypatch.setattr(module, name, interrupted)


PLACES = {
    "measuring": (recording, "measure"),
    "putting together": (recording, "build_result"),
    "writing": (files, "_as_dataset"),
    "the disk": (output_file, "_check_room"),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_waits_until_the_milestone_is_kept(
    coarse, tmp_path, monkeypatch, capsys, place, number, status
):
    signal_in(monkeypatch, PLACES[place], number, at_call=2)
    (tmp_path / "s.toml").write_text(specimen_to_toml(coarse))
    output = tmp_path / "run.nc"
    words = [str(tmp_path / "s.toml"), "--solver", "dshell", "--model", "hinge", "--quiet"]
    assert main(["solve", *words, "-o", str(output)]) == status
    assert capsys.readouterr().err == f"bilayer: interrupted; {output} has 2 of 4 milestones\n"
    assert open_result(output)["converged"].values.tolist() == [1, 1, 0, 0]
    monkeypatch.undo()
    assert main(["solve", *words, "-o", str(output), "--resume"]) == 0
    assert_same_numbers(open_result(output), solve(coarse, "dshell", HingeSettings()))


def test_a_signal_while_the_last_milestone_is_kept_loses_nothing(
    coarse, coarse_mesh, tmp_path, monkeypatch
):
    signal_in(monkeypatch, PLACES["measuring"], signal.SIGINT, at_call=4)
    with pytest.raises(Interrupted) as raised:
        solved(coarse, coarse_mesh, tmp_path / "run.nc")
    assert raised.value.result["converged"].values.all()
    assert open_result(tmp_path / "run.nc").attrs["stop_reason"] == ""


def test_a_signal_on_the_coarse_mesh_that_comes_first_gives_no_result_of_it(
    coarse_specimen, tmp_path, monkeypatch, capsys
):
    shape_is_handed_on = (coarse_start, "_share_within_hull")  # of the coarse mesh, to the fine one
    signal_in(monkeypatch, shape_is_handed_on, signal.SIGTERM, at_call=1)
    (tmp_path / "s.toml").write_text(specimen_to_toml(coarse_specimen.with_milestones([1.02])))
    words = [str(tmp_path / "s.toml"), "--solver", "dshell", "--quiet", "--mesh-size", "0.0045"]
    few = ["--set", "solver.coarse_triangles=120", "-o", str(tmp_path / "run.nc")]
    assert main(["solve", *words, *few]) == 143
    assert capsys.readouterr().err == "bilayer: interrupted\n"
    assert not (tmp_path / "run.nc").exists()


def test_a_signal_in_the_call_of_git_comes_before_anything_is_computed(
    coarse, coarse_mesh, tmp_path, monkeypatch
):
    signal_in(monkeypatch, (version, "_git"), signal.SIGINT, at_call=1)
    monkeypatch.setattr(version, "COMMIT_FILE", tmp_path / "no such file")
    (tmp_path / "one" / "two").mkdir(parents=True)
    monkeypatch.setattr(version, "__file__", str(tmp_path / "one" / "two" / "version.py"))
    (tmp_path / ".git").mkdir()
    steps = []
    with pytest.raises(KeyboardInterrupt):
        solved(coarse, coarse_mesh, tmp_path / "run.nc", observers=[steps.append])
    assert steps == []


@pytest.mark.parametrize("change", ["settings", "specimen", "milestones", "mesh"])
def test_another_run_does_not_go_on_from_a_file(coarse, coarse_mesh, tmp_path, monkeypatch, change):
    signal_in(monkeypatch, PLACES["measuring"], signal.SIGINT, at_call=2)
    output = tmp_path / "run.nc"
    with pytest.raises(Interrupted):
        solved(coarse, coarse_mesh, output)
    monkeypatch.undo()
    specimen, settings, mesh = coarse, HingeSettings(), None
    if change == "settings":
        settings = HingeSettings(ramp=0.02)
    elif change == "specimen":
        specimen = bilayer.parse_specimen(specimen_to_toml(coarse), ["gravity.acceleration=9.81"])
    elif change == "milestones":
        specimen = coarse.with_milestones([1.01, 1.02, 1.05, 1.06])
    else:
        mesh = bilayer.generate_mesh(killed_runs.specimen())
    with pytest.raises(InputError, match=rf"run\.nc: .*{change}"):
        solve(specimen, "dshell", settings, mesh=mesh, resume=output)
