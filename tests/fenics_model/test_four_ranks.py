"""The model split over more ranks than there are cores, each with little of a coarse mesh."""

from dataclasses import replace

import pytest

from bilayer import MeshSize, open_result, paper_specimen, solve
from bilayer.specimen.toml import specimen_to_toml

pytest.importorskip("dolfinx")


def test_four_ranks_that_own_little_give_what_one_gives(bilayer_on_ranks, tmp_path):
    specimen = replace(paper_specimen(), mesh=MeshSize(0.016)).with_milestones([1.03])
    (tmp_path / "specimen.toml").write_text(specimen_to_toml(specimen))
    bilayer_on_ranks(4, "solve", "specimen.toml", "--solver", "fenics", "-o", "four.nc", "--quiet")
    shared, alone = open_result(tmp_path / "four.nc"), solve(specimen, "fenics")
    for name in ("position", "volume_position"):
        assert shared[name].values == pytest.approx(alone[name].values, abs=1e-9)
    for name in ("iterations", "unstable_modes", "converged"):
        assert shared[name].values.tolist() == alone[name].values.tolist()
