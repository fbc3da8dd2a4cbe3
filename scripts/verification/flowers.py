"""The paper's specimen as the accurate shell releases it: meshes, petals and how far it goes."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from bilayer import CutPattern, MeshSize, PlanarMesh, Specimen, paper_specimen, solve
from bilayer.errors import ComputationError
from bilayer.mesh.generation import generate_mesh
from dshell import MorleySettings
from verification.bilayers import ladder_disc, petal_radii

CUT = CutPattern(5, 0.008, 0.3)


def flower(stretches: Sequence[float], size: float) -> tuple[Specimen, PlanarMesh, xr.Dataset]:
    """The ladder's disc with the paper's cut on a mesh of a size, every milestone stable."""
    specimen = ladder_disc(CUT, size).with_milestones(list(stretches))
    mesh = generate_mesh(specimen)
    result = solve(specimen, "dshell", MorleySettings(), mesh=mesh)
    if not result.converged.values.all() or result.unstable_modes.values.any():
        raise ComputationError(f"no stable shape on {size * 1e3:g} mm: {result.stop_reason}")
    return specimen, mesh, result


def five_fold(stretches: Sequence[float], size: float) -> tuple[Specimen, PlanarMesh, xr.Dataset]:
    """The template's five-fold equilibria, stable or not."""
    specimen = replace(paper_specimen(), mesh=MeshSize(size)).with_milestones(list(stretches))
    mesh = generate_mesh(specimen)
    result = solve(specimen, "dshell", MorleySettings(branch="unstable"), mesh=mesh)
    if not result.converged.values.all():
        raise ComputationError(f"no shape on {size * 1e3:g} mm: {result.stop_reason}")
    return specimen, mesh, result


def petal_spread(specimen: Specimen, mesh: PlanarMesh, shape: np.ndarray) -> float:
    """Largest difference of a petal's radius from their mean, over the mean."""
    radii = petal_radii(specimen, mesh, shape)
    return float(np.abs(radii / radii.mean() - 1).max())
