"""The two solvers of today against each other on one planar mesh of the cut disc."""

import pytest

from bilayer import solve
from bilayer.results.comparison import compare

pytest.importorskip("dolfinx")

MUST = {1.03: 0.0035, 1.06: 0.01}
"""Rms distance of the interfaces over R that rung 15 of the ladder asks for, by prestretch."""


def test_the_shell_finds_the_shapes_of_the_solid(paper_6mm, paper_6mm_mesh, paper_6mm_solid):
    shell = solve(paper_6mm, "dshell", mesh=paper_6mm_mesh)
    compared = compare(paper_6mm_solid, shell)
    assert compared["converged"].values.all()
    assert not compared["unstable"].values.any()
    for prestretch, must in MUST.items():
        found = compared.sel(prestretch=prestretch)
        assert float(found["rms_distance_over_radius"]) < must
        solid, of_shell = found["height"].values
        assert of_shell == pytest.approx(solid, rel=0.03)
