"""The branches at milestones where the path came to an unstable equilibrium, for the dataset."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from fenics_model.branches.branch_search import DEPARTED, MODE_SIDES, BranchSearchOutcome

NAMES = (DEPARTED, *MODE_SIDES)


def branch_dataset(departures: Sequence[BranchSearchOutcome | None], milestones: int) -> xr.Dataset:
    """Build `branch_energy`, `branch_unstable_modes` and `branch_taken` by milestone.

    Parameters
    ----------
    departures : sequence of BranchSearchOutcome or None
        Of the milestones in order; None if it was not reached or the path came to a stable one.
    milestones : int
        Number of milestones.
    """
    energy = np.full((milestones, len(NAMES)), np.nan)
    modes = np.full((milestones, len(NAMES)), -1, dtype=np.int32)
    taken = np.full(milestones, -1, dtype=np.int32)
    for row, departure in enumerate(departures):
        if departure is not None:
            energy[row] = [branch.energy for branch in departure.branches]
            modes[row] = [branch.unstable_modes for branch in departure.branches]
            taken[row] = NAMES.index(departure.taken)
    dims = ("prestretch", "branch")
    return xr.Dataset(
        {
            "branch_energy": (
                dims,
                energy,
                {"units": "J", "long_name": "potential energy of each branch that was looked at"},
            ),
            "branch_unstable_modes": (
                dims,
                modes,
                {"long_name": "unstable modes of each branch, -1 where there is none"},
            ),
            "branch_taken": (
                "prestretch",
                taken,
                {
                    "long_name": "branch of the milestone's shape where it had to be looked for",
                    "flag_values": np.arange(-1, len(NAMES), dtype=np.int32),
                    "flag_meanings": " ".join(("none_looked_for", *NAMES)),
                },
            ),
        },
        coords={
            "branch": (
                "branch",
                list(NAMES),
                {"long_name": "the unstable equilibrium, and either side of its mode"},
            )
        },
    )
