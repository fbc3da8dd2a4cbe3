"""What each milestone took, as variables of the dataset."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from fenics_model.solve.effort import Effort
from fenics_model.solve.work import Work


def effort_dataset(efforts: Sequence[Effort], works: Sequence[Work], milestones: int) -> xr.Dataset:
    """Build the variables of what was done to get to each milestone, and of the time it took.

    Parameters
    ----------
    efforts, works : sequence of Effort, of Work
        Of the milestones that were reached or tried, in order.
    milestones : int
        Number of milestones; those never tried took nothing.
    """
    return xr.merge([_counts(efforts, milestones), _seconds(works, milestones)])


def _seconds(works: Sequence[Work], milestones: int) -> xr.Dataset:
    rows = [*works, *[Work()] * (milestones - len(works))]
    factorisations = np.array([row.factorisations for row in rows], dtype=np.int32)
    note = "CPU time of the first rank"
    seconds = {
        "assembly_time": ([row.assembly for row in rows], f"{note} in assembly"),
        "factorisation_time": (
            [row.factorisation for row in rows],
            f"{note} in factorisations and the solutions with them",
        ),
        "cpu_time": ([row.total for row in rows], f"{note} in all, without the start's own"),
    }
    return xr.Dataset(
        {
            "factorisations": (
                "prestretch",
                factorisations,
                {"long_name": "factorisations, those for the stability included"},
            ),
            **{
                name: ("prestretch", np.array(values), {"units": "s", "long_name": text})
                for name, (values, text) in seconds.items()
            },
        }
    )


def _counts(efforts: Sequence[Effort], milestones: int) -> xr.Dataset:
    rows = [*efforts, *[Effort()] * (milestones - len(efforts))]
    return xr.Dataset(
        {
            "stabilised_steps": (
                "prestretch",
                np.array([row.flow_steps for row in rows], dtype=np.int32),
                {"long_name": "time steps of the viscous flow where no load step led on"},
            ),
            "dissipated_energy": (
                "prestretch",
                np.array([row.dissipated for row in rows]),
                {"units": "J", "long_name": "energy that the viscous flow took away"},
            ),
            "escapes": (
                "prestretch",
                np.array([row.escapes for row in rows], dtype=np.int32),
                {"long_name": "unstable equilibria at the milestone left for a stable one"},
            ),
            "guided_steps": (
                "prestretch",
                np.array([row.guided_steps for row in rows], dtype=np.int32),
                {"long_name": "load steps predicted by the start's shapes, failed ones included"},
            ),
        }
    )
