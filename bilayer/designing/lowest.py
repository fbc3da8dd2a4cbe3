"""Whether a checked design has a lower state, and how far that is from the target.

The shell looks for the stable shapes of the design at its prestretch, from the checked shape and
from starts of its own. From the lowest of them the finite-element model finds its own shape.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from bilayer.designing.checked import Checked, checked_from, solve_by_elements
from bilayer.designing.task import DESIGN_SOLVER, DesignTask
from bilayer.errors import ComputationError
from bilayer.landscape.catalogue import NOWHERE
from bilayer.landscape.lower import at_row, own_state
from bilayer.landscape.search import states
from bilayer.results.files import open_result
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import result_mesh
from bilayer.runtime.progress import Progress
from bilayer.solvers.registry import settings_class

STATES, LOWEST = "states.nc", "lowest.nc"
SAME_ENERGY = 1e-4
"""Relative difference of two shapes by finite elements that are one."""


@dataclass(frozen=True, eq=False)
class Lowest:
    """What a search for lower states found.

    Parameters
    ----------
    starts : int
        Of the search.
    states : int
        That it found.
    below : float
        Energy of the lowest state over that of the checked shape's own, by the shell, less 1; 0 if
        none is lower, NaN if the shell has no shape of its own there.
    below_by_elements : float
        The same by the finite-element model; NaN if it was not asked, or found none.
    lowest : Checked or None
        The lowest state as the finite-element model has it; None if it is the checked shape.
    """

    starts: int
    states: int
    below: float
    below_by_elements: float = np.nan
    lowest: Checked | None = None

    @property
    def is_checked_shape(self) -> bool:
        """Whether the checked shape is the lowest that is known, by finite elements if asked."""
        return self.below == 0 or self.below_by_elements > -SAME_ENERGY

    @property
    def words(self) -> str:
        """Description for a report, without the distance."""
        search = f"{self.starts} starts of the shell lead to {self.states} stable shapes"
        if self.below == 0:
            return f"{search}, and this is the lowest."
        if np.isnan(self.below):
            return f"{search}; the checked shape leads to none of them. {self._by_elements}"
        lower = f"By the shell another one has {-self.below:.2%} less energy."
        return f"{search}. {lower} {self._by_elements}"

    @property
    def _by_elements(self) -> str:
        """What the finite-element model says of the lowest of the shell's."""
        ratio = self.below_by_elements
        begin = "From the lowest of them the finite-element model comes to"
        if np.isnan(ratio):
            return f"{begin} no shape."
        if abs(ratio) <= SAME_ENERGY:
            return f"{begin} the checked shape."
        return f"{begin} a shape of {abs(ratio):.2%} {'more' if ratio > 0 else 'less'} energy."


def look_for_lowest(
    task: DesignTask, checked: Checked, folder: Path, progress: Progress | None = None
) -> Lowest:
    """Return whether a checked design has a lower state; what was found before is read.

    Parameters
    ----------
    task : DesignTask
        With the number of starts.
    checked : Checked
        Its last check.
    folder : Path
        Of the files of the search.
    progress : callable, optional
        See `bilayer.runtime.progress.Progress`.
    """
    starts = task.check.starts
    own = along_milestones(open_result(checked.file)).isel(prestretch=[-1])
    specimen = at_row(own, -1)
    file = folder / STATES
    settings = settings_class(DESIGN_SOLVER)(contact=task.check.contact)
    try:
        found = states(
            specimen, settings, starts=starts, mesh=checked.mesh, start=own,
            progress=progress, output=file, resume=file if file.exists() else None,
        )  # fmt: skip
    except ComputationError:
        return Lowest(starts, 0, np.nan)
    count, place = found.sizes["prestretch"], own_state(found)
    energy = found["energy"].sum("term").values
    if place == 0:
        return Lowest(starts, count, 0.0)
    below = np.nan if place == NOWHERE else float(energy[0] / energy[place] - 1)
    lowest = found.isel(prestretch=[0])
    there = solve_by_elements(
        task, at_row(lowest, -1), result_mesh(lowest), folder / LOWEST, progress, start=lowest
    )
    if there is None:
        return Lowest(starts, count, below)
    ratio = _energy(there) / _energy(own) - 1
    return Lowest(starts, count, below, ratio, checked_from(task, there, folder / LOWEST))


def _energy(result: xr.Dataset) -> float:
    return float(result["energy"].sum("term").values[-1])
