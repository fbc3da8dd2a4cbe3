"""The ladder's cases made importable (`verification`), and results that several tests look at."""

import sys
from dataclasses import replace
from pathlib import Path

import pytest

from bilayer import MeshSize, generate_mesh, paper_specimen, solve

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))


@pytest.fixture(scope="session")
def paper_6mm():
    """The paper's specimen on a mesh of 6 mm, the coarsest that is used for results."""
    return replace(paper_specimen(), mesh=MeshSize(0.006)).with_milestones([1.03, 1.06])


@pytest.fixture(scope="session")
def paper_6mm_mesh(paper_6mm):
    return generate_mesh(paper_6mm)


@pytest.fixture(scope="session")
def paper_6mm_solid(paper_6mm, paper_6mm_mesh):
    """Its shapes by this model, with the defaults."""
    return solve(paper_6mm, "fenics", mesh=paper_6mm_mesh)
