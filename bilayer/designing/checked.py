"""The finite-element model's word on a design: what is reported as reached is what it finds.

It computes the designed specimen through milestones of the prestretch, from a start of its own.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.designing.distance import Distance, TargetDistance
from bilayer.designing.task import DesignTask
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import result_mesh
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import settings_class, solve
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

CHECK_SOLVER = "fenics"


@dataclass(frozen=True, eq=False)
class Checked:
    """A design as the finite-element model has it.

    Parameters
    ----------
    mesh : PlanarMesh
        The planar mesh.
    position : (n, 3) array of float
        The reference surface, m.
    distance : Distance
        From the target.
    quality, hemisphere_distance, gap : float
        As in a result; m.
    unstable_modes : int
        Left in the equilibrium.
    iterations : int
        Of all milestones.
    file : Path
        The result.
    """

    mesh: PlanarMesh
    position: Array
    distance: Distance
    quality: float
    hemisphere_distance: float
    gap: float
    unstable_modes: int
    iterations: int
    file: Path

    @property
    def surface(self) -> Surface:
        """The reference surface."""
        return Surface(self.position, self.mesh.triangles)

    @property
    def words(self) -> str:
        """Description for a report."""
        stable = {0: "stable", -1: "not looked at for stability"}.get(
            self.unstable_modes, f"unstable in {self.unstable_modes} modes"
        )
        touches = "touches itself" if self.gap == 0 else "does not touch itself"
        return (
            f"Its shape is {stable} and {touches} ({len(self.mesh.triangles)} triangles, "
            f"{self.iterations} iterations; [{self.file.name}]({self.file.name}))."
        )


def check_design(
    task: DesignTask,
    specimen: Specimen,
    mesh: PlanarMesh | None,
    file: Path,
    progress: Progress | None = None,
) -> Checked | None:
    """Return a design as the finite-element model has it; None if it does not reach it.

    A run that was killed goes on from its file, one that is finished is read.

    Parameters
    ----------
    task : DesignTask
        What is wanted.
    specimen : Specimen
        The design.
    mesh : PlanarMesh or None
        The planar mesh; made from the specimen if None.
    file : Path
        The result.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    """
    by_steps = specimen.with_milestones(
        milestones_to(specimen.prestretch.milestones[-1], task.check.step)
    )
    result = solve_by_elements(task, by_steps, mesh, file, progress)
    return None if result is None else checked_from(task, result, file)


def solve_by_elements(
    task: DesignTask,
    specimen: Specimen,
    mesh: PlanarMesh | None,
    file: Path,
    progress: Progress | None = None,
    start: xr.Dataset | None = None,
) -> xr.Dataset | None:
    """Return the shapes of a design by the finite-element model; None if it misses the last one.

    Parameters
    ----------
    task, mesh, file, progress
        See `check_design`.
    specimen : Specimen
        The design, with its milestones.
    start : Dataset, optional
        A result whose shapes lead; see `bilayer.solve`.
    """
    settings = settings_class(CHECK_SOLVER)(contact=task.check.contact)
    result = solve(
        specimen, CHECK_SOLVER, settings, mesh=mesh, start=start, progress=progress,
        output=file, resume=file if file.exists() else None,
    )  # fmt: skip
    return result if bool(result["converged"].values[-1]) else None


def checked_from(task: DesignTask, result: xr.Dataset, file: Path) -> Checked:
    """Return the last milestone of a result of the finite-element model.

    Parameters
    ----------
    task : DesignTask
        What is wanted.
    result : Dataset
        The result.
    file : Path
        Where it is.
    """
    mesh, position = result_mesh(result), result["position"].values[-1]
    distance = TargetDistance(task.target.surface, task.target.is_size_free)
    last = result.isel(prestretch=-1) if "prestretch" in result.dims else result
    return Checked(
        mesh,
        position,
        distance.measure_anew(Surface(position, mesh.triangles)),
        float(last["quality"]),
        float(last["hemisphere_distance"]),
        float(last["self_contact_gap"]),
        int(last["unstable_modes"]),
        int(np.nansum(result["iterations"].values)),
        file,
    )


def milestones_to(stretch: StretchPair, step: float) -> list[StretchPair]:
    """Return the prestretches on the way to one, none farther from the one before than a step.

    Examples
    --------
    >>> milestones_to((1.25, 1.25), 0.1)
    [(1.1, 1.1), (1.2, 1.2), (1.25, 1.25)]
    """
    x, y = stretch
    count = max(1, math.ceil(max(abs(x - 1), abs(y - 1)) / step - 1e-9))
    way = step / max(abs(x - 1), abs(y - 1)) if count > 1 else 1.0
    shares = [k * way for k in range(1, count)]
    on_the_way = [(round(1 + s * (x - 1), 9), round(1 + s * (y - 1), 9)) for s in shares]
    return [*on_the_way, stretch]
