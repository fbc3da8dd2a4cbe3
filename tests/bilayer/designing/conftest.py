from dataclasses import replace

import numpy as np
import pytest

import bilayer

RADIUS = 0.04


@pytest.fixture(scope="session")
def profiled():
    """The paper's specimen on a coarse mesh, its cutouts a profile without equal neighbours."""
    pattern = bilayer.SectorProfile(
        5, tuple(np.linspace(0.2, 1, 4) * RADIUS), (0.12, 0.16, 0.19, 0.24)
    )
    specimen = bilayer.paper_specimen().with_layer("kirigami", pattern=pattern, thickness=1.5e-3)
    return replace(specimen, mesh=bilayer.MeshSize(0.009)).with_milestones([1.12])
