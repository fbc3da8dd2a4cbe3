"""The opening of a path: the mesh and the start are made on the first rank, for all."""

from collections.abc import Callable
from typing import Any

import xarray as xr
from mpi4py import MPI

from bilayer.errors import BilayerError
from bilayer.mesh.generation import mesh_within_memory
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.start_shapes import StartShapes
from bilayer.results.starting import describe_run, describe_start
from bilayer.runtime.memory import available_memory
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Start
from bilayer.specimen.specimen import Specimen, refuse_fields
from fenics_model.release.solid_path import SolidPath
from fenics_model.settings import SolidSettings, bytes_per_triangle


def open_solid_path(
    specimen: Specimen,
    settings: SolidSettings,
    *,
    mesh: PlanarMesh | None,
    start: Start,
    comm: MPI.Comm | None,
    progress: Progress | None = None,
) -> SolidPath:
    """Return the path of a specimen's solid, on the ranks of `comm`; None: all."""
    refuse_fields(specimen, "the finite-element model")
    comm = MPI.COMM_WORLD if comm is None else comm
    available = available_memory(comm)
    planar: PlanarMesh = from_first_rank(
        comm, lambda: _make_mesh(specimen, mesh, settings, available)
    )
    made, text = _make_start(None if specimen.loads else start, planar, comm)
    shapes = None if made is None else StartShapes.of(made, planar)
    told = progress if comm.rank == 0 else None
    return SolidPath(specimen, planar, settings, comm, shapes, text, told)


def from_first_rank(comm: MPI.Comm, make: Callable[[], Any]) -> Any:
    """Return on every rank what `make` gives, or raise what it raises, on the first."""
    made: Any = None
    if comm.rank == 0:
        try:
            made = make()
        except BilayerError as error:
            made = error
    made = comm.bcast(made)
    if isinstance(made, BilayerError):
        raise made
    return made


def _make_mesh(
    specimen: Specimen, mesh: PlanarMesh | None, settings: SolidSettings, available: float
) -> PlanarMesh:
    """Return the mesh of a run if the machines of all ranks together have the memory for it."""
    needed = bytes_per_triangle(specimen, settings)
    return mesh_within_memory(specimen, mesh, needed, "the finite-element model", available)


def _make_start(start: Start, mesh: PlanarMesh, comm: MPI.Comm) -> tuple[xr.Dataset | None, str]:
    """Return a start, made if it is not there yet, and a line about it."""
    if start is None or isinstance(start, xr.Dataset):
        return start, describe_start(start)
    try:
        made: xr.Dataset = from_first_rank(comm, lambda: start(mesh))
    except BilayerError as error:
        return None, f"flat, because {error}"
    return made, describe_run(made)
