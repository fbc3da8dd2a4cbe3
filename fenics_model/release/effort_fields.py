"""The work for each milestone, as variables of the dataset."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from fenics_model.solve.effort import Effort, Work


def effort_dataset(efforts: Sequence[Effort | None], milestones: int) -> xr.Dataset:
    """Build the variables of the work for each milestone, and of the time that it took.

    Parameters
    ----------
    efforts : sequence of Effort or None
        Of the milestones that were reached or tried, in order; None if another run did.
    milestones : int
        Number of milestones; those never tried took nothing.
    """
    missing = [None] * (milestones - len(efforts))
    rows = [Effort() if effort is None else effort for effort in (*efforts, *missing)]
    return xr.merge([_counts(rows), _seconds([row.work for row in rows])])


def _seconds(rows: Sequence[Work]) -> xr.Dataset:
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


def _counts(rows: Sequence[Effort]) -> xr.Dataset:
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
