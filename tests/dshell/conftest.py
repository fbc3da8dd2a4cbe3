import sys
from dataclasses import replace
from pathlib import Path

import pytest

from bilayer import MeshSize, PlanarMesh, Specimen, generate_mesh, paper_specimen

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))  # the package `verification`


@pytest.fixture(scope="session")
def coarse_specimen() -> Specimen:
    return replace(paper_specimen(), mesh=MeshSize(0.01))


@pytest.fixture(scope="session")
def coarse_mesh(coarse_specimen: Specimen) -> PlanarMesh:
    return generate_mesh(coarse_specimen)
