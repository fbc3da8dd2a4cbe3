"""The discrete shell from a specimen to a result."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import scipy
import xarray as xr

from bilayer.errors import InputError
from bilayer.mesh_generation import check_memory, generate_mesh
from bilayer.planar_mesh import PlanarMesh
from bilayer.result import build_result
from bilayer.solvers import Progress
from bilayer.specimen import Specimen
from dshell.paper_model import release
from dshell.settings import PaperSettings

PARALLEL = False
"""Under mpirun the first rank computes alone."""

BYTES_PER_TRIANGLE = 25_000
"""Memory that a run takes (measured: 14 kB per triangle at 6 000 triangles, 24 kB at 19 000)."""

MODELS = {"paper": PaperSettings}


def solve(
    specimen: Specimen,
    settings: PaperSettings,
    *,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | None = None,
    comm: Any = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the shapes of a specimen at its milestones, each a run of its own from flat.

    Parameters
    ----------
    specimen : Specimen
        What to release; its true weight must be zero.
    settings : PaperSettings
        What the paper leaves open; its `thickness` takes the place of the specimen's rule.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen where left out.
    start : None
        This model has no use for a start.
    comm : mpi4py.MPI.Comm, optional
        Not used: each rank that calls computes the whole result.
    progress : callable, optional
        See `bilayer.solvers.Progress`.

    Returns
    -------
    Dataset
        See `bilayer.result`. A milestone whose run stopped converging has its last shape in
        `last_position`; `stop_reason` says where it stopped and why.

    Raises
    ------
    InputError
        A start or a true weight is given, the settings are of another kind, or the mesh would not
        fit into memory.
    """
    _check_input(specimen, settings, start)
    if mesh is None:
        check_memory(specimen, BYTES_PER_TRIANGLE, "the discrete shell")
        mesh = generate_mesh(specimen)
    ruled = replace(specimen, prestretch=replace(specimen.prestretch, thickness=settings.thickness))
    releases = [
        release(ruled, mesh, stretch, settings, _milestone_report(progress, specimen, index))
        for index, stretch in enumerate(ruled.prestretch.milestones)
    ]
    return build_result(
        specimen,
        mesh,
        [done.state for done in releases],
        solver="dshell",
        model="paper",
        settings=settings,
        versions={"scipy": scipy.__version__},
        stop_reason="; ".join(done.stop_reason for done in releases if done.stop_reason),
    )


def _check_input(specimen: Specimen, settings: PaperSettings, start: xr.Dataset | None) -> None:
    if not isinstance(settings, PaperSettings):
        raise InputError(f"settings = {settings!r}: expected PaperSettings")
    if start is not None:
        raise InputError(
            "start = a result: the paper's model runs each milestone from flat, expected none"
        )
    if specimen.gravity > 0:
        raise InputError(
            f"gravity.acceleration = {specimen.gravity} m/s2: the paper's model ends without "
            "weight (its gravity tapers to zero), expected 0"
        )


def _milestone_report(
    progress: Progress | None, specimen: Specimen, index: int
) -> Callable[[float], None]:
    """Return what passes the share of one milestone's ramp on as progress of the whole."""
    prestretches = specimen.prestretch.nominal

    def report(share: float) -> None:
        if progress is not None:
            text = f"prestretch {prestretches[index]:g}, {share:.0%} of the ramp"
            progress((index + share) / len(prestretches), text)

    return report
