"""A resume point that is none of the solver's: refused in a line, before anything is computed."""

from dataclasses import replace

import netCDF4
import numpy as np
import pytest

pytest.importorskip("dolfinx")

from bilayer import MeshSize, paper_specimen, solve
from bilayer.errors import Interrupted, NotResumableError

SPECIMEN = replace(paper_specimen(), mesh=MeshSize(0.02)).with_milestones([1.002, 1.004])


@pytest.fixture(scope="module")
def unfinished(tmp_path_factory):
    file = tmp_path_factory.mktemp("run") / "run.nc"

    def stop(step):
        if step.is_at_target:
            raise KeyboardInterrupt

    with pytest.raises(Interrupted):
        solve(SPECIMEN, "fenics", start="flat", output=file, observers=[stop])
    return file.read_bytes()


def without(name):
    return lambda group: group.renameVariable(name, "other")


def odd(name, values):
    """Return a change: other values, of another length, in the place of a variable."""

    def change(group):
        values_there = np.asarray(values)
        group.renameVariable(name, "other")
        dims = [f"odd{axis}" for axis in range(values_there.ndim)]
        for dim, size in zip(dims, values_there.shape, strict=True):
            group.createDimension(dim, size)
        kind = str if values_there.dtype.kind == "U" else values_there.dtype
        group.createVariable(name, kind, dims)[...] = values_there

    return change


@pytest.mark.parametrize(
    "change",
    [
        without("equilibrium"),
        without("equilibrium_parameter"),
        without("step"),
        without("start"),
        odd("step", np.zeros(0)),
        odd("targets", np.ones((2, 3))),
        odd("equilibrium", np.zeros((2, 7))),
        odd("failures", np.array(["many"])),
    ],
)
def test_it_is_refused_in_a_line(unfinished, change, tmp_path):
    file = tmp_path / "run.nc"
    file.write_bytes(unfinished)
    with netCDF4.Dataset(file, "a") as stored:
        change(stored["resume"])
    with pytest.raises(NotResumableError, match=r"run\.nc: its resume point is none") as raised:
        solve(SPECIMEN, "fenics", output=file, resume=file)
    assert "\n" not in str(raised.value)
    assert list(tmp_path.iterdir()) == [file]


def test_a_good_one_is_gone_on_from(unfinished, tmp_path):
    file = tmp_path / "run.nc"
    file.write_bytes(unfinished)
    result = solve(SPECIMEN, "fenics", output=file, resume=file)
    assert result["converged"].values.tolist() == [1, 1]
