"""The shell under mpirun: one rank computes, and the other does not hold it up."""

import pytest

from bilayer import open_result
from bilayer.specimen.toml import template

pytest.importorskip("mpi4py.MPI")
COARSE = ["--mesh-size", "0.016", "--prestretch", "1.03", "--quiet"]


def test_the_first_of_two_ranks_computes(bilayer_on_ranks, tmp_path):
    (tmp_path / "specimen.toml").write_text(template())
    words = ["solve", "specimen.toml", "--solver", "dshell", "-o", "shell.nc", *COARSE]
    bilayer_on_ranks(2, *words)
    assert open_result(tmp_path / "shell.nc")["converged"].values.tolist() == [1]
    bilayer_on_ranks(2, "rerun", "shell.nc", "--quiet")
