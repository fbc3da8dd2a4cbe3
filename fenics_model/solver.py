"""The 3D finite-element model of a sheet: mixed displacement-pressure, hyperelastic, released.

The planar mesh is extruded through all layers, a layer's prestretch is its natural state, and
Newton's method follows the equilibria while it changes. dolfinx is loaded by `open_path` alone.
"""

import sys
from typing import Any

from bilayer.errors import ComputationError, InputError, MachineError
from bilayer.mesh.planar import PlanarMesh
from bilayer.runtime.petsc import start_petsc
from bilayer.runtime.progress import Progress
from bilayer.solvers.contract import Solver, SpecimenPath, Start
from bilayer.specimen.specimen import Specimen
from fenics_model.settings import MODELS, SolidSettings, bytes_per_triangle


def open_path(
    specimen: Specimen,
    settings: Any,
    *,
    mesh: PlanarMesh | None,
    start: Start,
    comm: Any,
    progress: Progress | None,
) -> SpecimenPath:
    """Return the load path of a specimen's solid; see `bilayer.solvers.contract.OpenPath`.

    The weight, if any, is a dead load along -z that the centre carries, see
    `bilayer.specimen.support`. The shapes of `start` are the initial guesses. If one cannot be made
    or does not lead to a stable equilibrium, load steps are taken instead.
    """
    _need_docstrings()
    start_petsc()  # before dolfinx does it, with the options of the user's environment
    try:
        import dolfinx.fem.petsc  # noqa: F401
        import slepc4py  # noqa: F401
    except ImportError as error:
        raise ComputationError(
            f"the finite-element model needs dolfinx with PETSc and SLEPc ({error}): run "
            "scripts/bilayer of the checkout, or install them (on Debian 13 and later: apt install "
            "python3-dolfinx python3-slepc4py)"
        ) from error
    from fenics_model.release.opening import open_solid_path

    if not isinstance(settings, SolidSettings):
        raise InputError(f"settings = {settings!r}: expected SolidSettings")
    return open_solid_path(specimen, settings, mesh=mesh, start=start, comm=comm, progress=progress)


def _need_docstrings() -> None:
    """Raise MachineError under `python -OO`: the parser of the compiled forms is made of them."""
    if sys.flags.optimize > 1:
        raise MachineError(
            "the finite-element model needs the docstrings of Python's modules: start Python "
            "without -OO or PYTHONOPTIMIZE=2"
        )


SOLVER = Solver(
    name="fenics",
    models=MODELS,
    parallel=True,
    bytes_per_triangle=bytes_per_triangle,
    default_start="shell",
    open_path=open_path,
)
