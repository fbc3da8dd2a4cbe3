"""The 3D finite-element model of a bilayer: mixed displacement-pressure, hyperelastic, released.

The planar mesh is extruded through both layers, a layer's prestretch is its natural state,
and Newton's method follows the equilibria while it grows. dolfinx is loaded by `solve` alone.
"""

from collections.abc import Callable
from typing import Any

import xarray as xr

from bilayer.errors import ComputationError, InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.runtime.progress import Progress
from bilayer.specimen.specimen import Specimen
from fenics_model.settings import SolidSettings

PARALLEL = True
"""The ranks of mpirun share one model."""

DEFAULT_START = "shell"
"""One of `bilayer.solvers.registry.STARTS`."""


def solve(
    specimen: Specimen,
    settings: SolidSettings | None = None,
    *,
    mesh: PlanarMesh | None = None,
    start: xr.Dataset | Callable[[PlanarMesh], xr.Dataset] | None = None,
    comm: Any = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Compute the released shapes of a specimen with the finite-element model.

    Parameters
    ----------
    specimen : Specimen
        What to release. Its weight, if any, is a dead load along -z that the centre carries, see
        `bilayer.specimen.support`.
    settings : SolidSettings, optional
        The defaults where left out.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen where left out.
    start : Dataset or callable, optional
        A result on the same planar mesh, from any solver, or a function that makes one on the mesh
        it is given, called on the first rank: its shape nearest to the first milestone starts the
        first milestone, and those at and between the others lead to them. Where it cannot be made
        or does not lead to a stable equilibrium, the load path goes on from where it is; flat where
        left out.
    comm : mpi4py.MPI.Comm, optional
        The ranks that share the model; COMM_WORLD where left out. All call with the same
        arguments and get the same dataset; the mesh is that of the first rank.
    progress : callable, optional
        Called on the first rank, see `bilayer.runtime.progress.Progress`.

    Returns
    -------
    Dataset
        See `bilayer.results.schema`; with the volume mesh and its positions as further variables.

    Raises
    ------
    ComputationError
        dolfinx is not there, or gmsh fails.
    InputError
        The settings are not of this model, `start` is on another mesh, or the model does not fit
        into memory.
    """
    try:
        import dolfinx.fem.petsc  # noqa: F401
        import slepc4py  # noqa: F401
    except ImportError as error:
        raise ComputationError(
            f"the finite-element model needs dolfinx with PETSc and SLEPc ({error}): run inside "
            "scripts/env, or install them (on Debian 13 and later: apt install python3-dolfinx "
            "python3-slepc4py)"
        ) from error
    from fenics_model.release.release import release

    chosen = SolidSettings() if settings is None else settings
    if not isinstance(chosen, SolidSettings):
        raise InputError(f"settings = {chosen!r}: expected SolidSettings")
    return release(specimen, chosen, mesh=mesh, start=start, comm=comm, progress=progress)
