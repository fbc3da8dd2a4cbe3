"""The variables of a result that tell how the body touches itself, if contact was modelled."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from bilayer.contact.touching import Touching
from bilayer.results.schema import CONTACT_CROSSES


def contact_dataset(touching: Sequence[Touching | None], faces: int, count: int) -> xr.Dataset:
    """Return the contact at each milestone.

    Parameters
    ----------
    touching : sequence of Touching or None
        Of the milestones so far; None if one was not reached, or an earlier run has tried it.
    faces : int
        Triangles of the planar mesh.
    count : int
        Milestones of the specimen.
    """
    rows = [*touching, *[None] * (count - len(touching))]

    def column(name: str) -> np.ndarray:
        return np.array([np.nan if row is None else float(getattr(row, name)) for row in rows])

    nowhere = np.full(faces, np.nan)
    pressure = np.array([nowhere if row is None else row.pressure for row in rows])
    return xr.Dataset(
        {
            "contact_gap": (
                "prestretch", column("gap"),
                {"units": "m", "long_name": "smallest distance of two places of the skin, "
                                            "infinite beyond the range of the barrier"},
            ),
            "contact_force": (
                "prestretch", column("force"),
                {"units": "N", "long_name": "sum of the forces between places that touch"},
            ),
            "contact_pressure": (
                ("prestretch", "face"), pressure,
                {"units": "Pa", "long_name": "contact pressure", "mesh": "midsurface",
                 "location": "face"},
            ),
            "contact_pairs": (
                "prestretch", column("pairs"),
                {"units": "1", "long_name": "pairs of places within range of the barrier"},
            ),
            CONTACT_CROSSES: (
                "prestretch", column("crosses"),
                {"units": "1", "long_name": "whether the skin passes through itself all the same"},
            ),
        }
    )  # fmt: skip
