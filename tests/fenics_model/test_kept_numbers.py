"""A result of an earlier version is read, and computed again to the same numbers."""

from pathlib import Path

import pytest

pytest.importorskip("dolfinx")

from bilayer import open_result, result_mesh, result_specimen, solve

KEPT = Path(__file__).parents[2] / "results" / "paper" / "fenics.nc"


@pytest.fixture(scope="module")
def kept():
    return open_result(KEPT)


def test_the_paper_s_disc_keeps_its_numbers(kept):
    """On the file's own mesh, its own shape leading the way."""
    specimen = result_specimen(kept).with_milestones([1.03])
    again = solve(specimen, "fenics", mesh=result_mesh(kept), start=kept)
    before = kept.sel(prestretch=[1.03])
    assert again["unstable_modes"].values.tolist() == [0]
    radius = specimen.characteristic_length
    assert again["position"].values == pytest.approx(before["position"].values, abs=1e-9 * radius)
    for name in ("quality", "sphere_radius", "height", "energy"):
        assert again[name].values == pytest.approx(before[name].values, rel=1e-9), name
    for name in ("volume_reference_position", "volume_cells", "layer"):
        assert (again[name].values == before[name].values).all(), name
