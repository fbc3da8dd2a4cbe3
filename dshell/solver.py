"""The discrete shell as a solver: from a specimen to its load path.

What a path is made of is loaded by `open_path` alone, so that its settings are at hand at once.
"""

from typing import Any

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Solver, SpecimenPath, Start, StateFinder
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen
from dshell.settings import HingeSettings, MorleySettings, PaperSettings, ReleaseSettings

BYTES_PER_TRIANGLE = 50_000
"""Memory that a run takes: `scripts/benchmark dshell --largest 100000` measures it."""

MODELS = {"morley": MorleySettings, "hinge": HingeSettings, "paper": PaperSettings}


def open_path(
    specimen: Specimen,
    settings: Any,
    *,
    mesh: PlanarMesh | None = None,
    start: Start = None,
    comm: Any = None,
    progress: Progress | None = None,
) -> SpecimenPath:
    """Return the load path of a specimen; see `bilayer.solvers.contract.OpenPath`.

    Parameters
    ----------
    specimen : Specimen
        What to release. Its weight, if any, is a dead load along -z that the centre carries, see
        `bilayer.specimen.support`; the paper's model has none.
    settings : MorleySettings, HingeSettings or PaperSettings
        Their type chooses the model.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen if left out.
    start : Dataset or callable, optional
        A result on the same planar mesh, from any solver: its shape nearest to the first target
        leads to it. The paper's model has no use for it.
    comm : mpi4py.MPI.Comm, optional
        Not used: each rank that calls computes the whole path.
    progress : callable, optional
        Told of a coarse mesh that comes first.

    Raises
    ------
    InputError
        The settings are of no model, the start is on another mesh, the paper's model is given a
        start, a true weight or layers that it has not, or the mesh would not fit into memory.
    """
    if not any(type(settings) is kind for kind in MODELS.values()):
        kinds = ", ".join(kind.__name__ for kind in MODELS.values())
        raise InputError(f"settings = {settings!r}: expected one of {kinds}")
    from bilayer.mesh.generation import mesh_within_memory
    from dshell.release.opening import CoarseStart, open_shell_path

    mesh = mesh_within_memory(specimen, mesh, BYTES_PER_TRIANGLE, "the discrete shell")
    return open_shell_path(specimen, settings, mesh, start, CoarseStart(SOLVER, progress))


def open_finder(
    specimen: Specimen,
    settings: Any,
    stretch: StretchPair,
    *,
    mesh: PlanarMesh | None = None,
) -> StateFinder:
    """Return a finder of stable shapes; see `bilayer.solvers.contract.OpenFinder`.

    Parameters
    ----------
    specimen : Specimen
        The specimen.
    settings : MorleySettings or HingeSettings
        Their type chooses the model.
    stretch : (float, float)
        The prestretch.
    mesh : PlanarMesh, optional
        The planar mesh; made from the specimen if left out.

    Raises
    ------
    InputError
        The settings are of another model, or the mesh would not fit into memory.
    """
    if not isinstance(settings, ReleaseSettings):
        raise InputError(
            f"model: {type(settings).__name__} has no search for stable shapes, expected the "
            "settings of morley or hinge"
        )
    from bilayer.mesh.generation import mesh_within_memory
    from dshell.release.opening import open_shell_finder

    mesh = mesh_within_memory(specimen, mesh, BYTES_PER_TRIANGLE, "the discrete shell")
    return open_shell_finder(specimen, settings, mesh, stretch)


def _takes_neighbours(settings: Any) -> bool:
    """Whether a path goes downhill to stable states, which a shape nearby leads to as well."""
    is_static = isinstance(settings, ReleaseSettings) and settings.method == "static"
    return is_static and settings.branch == "lowest"


SOLVER = Solver(
    name="dshell",
    models=MODELS,
    parallel=False,
    bytes_per_triangle=lambda specimen, settings: BYTES_PER_TRIANGLE,
    default_start="flat",
    open_path=open_path,
    has_layers=lambda settings: isinstance(settings, MorleySettings),
    takes_neighbours=_takes_neighbours,
    open_finder=open_finder,
)
"""This package, as the registry finds it."""
