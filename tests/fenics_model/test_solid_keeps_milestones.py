"""A run that is killed keeps every milestone that it reached, and another goes on from there."""

import os
import random
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import killed_run
import numpy as np
import pytest

pytest.importorskip("dolfinx")

from bilayer import open_result
from bilayer.results.files import open_resume_point

COUNT = len(killed_run.MILESTONES)


@pytest.fixture(scope="module")
def undisturbed():
    """The result of the run without a kill, and the seconds that it takes."""
    killed_run.compute(None, None)  # so that everything is compiled
    begin = time.monotonic()
    result = killed_run.compute(None, None)
    return result, time.monotonic() - begin


class KilledRun:
    """A run on some ranks in processes of its own."""

    def __init__(self, folder, ranks):
        self.output, self._log = folder / "run.nc", folder / "log"
        self._logs = [Path(f"{self._log}.{rank}") for rank in range(ranks)]
        for log in self._logs:
            log.unlink(missing_ok=True)
        launched = ("OMPI_COMM", "PMIX", "PRTE")  # by an mpirun that these tests run under
        clean = {k: v for k, v in os.environ.items() if not k.startswith(launched)}
        launcher = ["mpirun", "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, sys.executable, killed_run.__file__, self.output, self._log]
        self._process = subprocess.Popen(
            list(map(str, command)), cwd=folder, env=clean, stderr=subprocess.DEVNULL
        )

    def wait(self):
        assert self._process.wait(timeout=300) == 0

    def kill_after(self, milestones, seconds):
        """Kill every rank some seconds after a number of milestones; return those noted."""
        while not all(self._has_noted(log, milestones) for log in self._logs):
            if self._process.poll() is not None:
                break
            time.sleep(0.01)
        time.sleep(seconds)
        for log in self._logs:
            with suppress(ProcessLookupError):  # it had finished
                os.kill(int(log.read_text().split()[0]), signal.SIGKILL)
        self._process.wait(timeout=60)
        return [int(line) for line in self._logs[0].read_text().split()[1:]]

    @staticmethod
    def _has_noted(log, milestones):
        return log.exists() and log.read_text().count("\n") > milestones


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_run_killed_at_any_moment_goes_on_to_the_same_numbers(tmp_path, undisturbed, ranks):
    expected, seconds = undisturbed
    moments, kept = random.Random(13 + ranks), []
    for milestones in (0, 1, 1, 1):
        run = KilledRun(tmp_path, ranks)
        noted = run.kill_after(milestones, moments.uniform(0.0, 0.3) * ranks * seconds)
        kept.append(assert_keeps(run.output, expected, noted))
    assert kept == sorted(kept)
    assert 0 < kept[1] < COUNT
    KilledRun(tmp_path, ranks).wait()
    result = open_result(run.output)
    assert open_resume_point(run.output) is None
    for name, variable in expected.data_vars.items():
        if variable.dtype.kind in "fi" and variable.attrs.get("units") != "s":
            np.testing.assert_allclose(result[name], variable, rtol=1e-9, atol=1e-11, err_msg=name)
    assert result.attrs["stop_reason"] == ""


def assert_keeps(output, expected, noted):
    """Check that a file has the milestones that were noted; return how many it has."""
    if not output.exists():
        assert noted == []
        return 0
    found = open_result(output)
    kept = int(found["converged"].sum())
    assert found["converged"].values.tolist() == [1] * kept + [0] * (COUNT - kept)
    assert kept > max(noted, default=-1)
    for name in ("position", "volume_position"):
        there, right = found[name].values[:kept], expected[name].values[:kept]
        assert there == pytest.approx(right, abs=1e-9)
    return kept
