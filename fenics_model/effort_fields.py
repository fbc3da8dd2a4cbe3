"""What the flow to a stable equilibrium did, as variables of the dataset by milestone."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from fenics_model.effort import Effort


def effort_dataset(efforts: Sequence[Effort], milestones: int) -> xr.Dataset:
    """Build the variables `stabilised_steps`, `dissipated_energy`, `escapes`, `guided_steps`.

    Parameters
    ----------
    efforts : sequence of Effort
        Of the milestones that were reached or tried, in order.
    milestones : int
        Number of milestones; those never tried took nothing.
    """
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
