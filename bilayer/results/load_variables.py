"""The loads in a result: the value of each at every milestone, and what it does its work on.

A load NAME has two variables over the milestones: `load_NAME`, a coordinate, and `response_NAME`.
The response of a pressure is the volume that it has swept, that of a force the displacement along
it, that of a displacement the force. The work of a load is the integral of one over the other. An
imposed displacement also has `displacement_NAME`, the one that was reached, free or not.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.mesh.parts import node_shares
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import MilestoneState
from bilayer.specimen.load import RESPONSES, Load
from bilayer.specimen.specimen import Specimen

LOAD, RESPONSE, REACHED = "load_", "response_", "displacement_"
"""Beginnings of the names of variables."""


def load_coordinates(specimen: Specimen) -> dict[str, Any]:
    """Return the coordinates of the loads, NaN where a displacement is free."""
    return {
        f"{LOAD}{load.name}": (
            "prestretch",
            np.array([load.at(k) for k in range(len(specimen.milestones))]),
            {"units": load.unit, "long_name": load.words},
        )
        for load in specimen.loads
    }


def response_variables(
    specimen: Specimen, mesh: PlanarMesh, rows: Sequence[MilestoneState]
) -> dict[str, Any]:
    """Return what the loads do their work on, NaN where a milestone was not reached."""
    variables: dict[str, Any] = {}
    for load in specimen.loads:
        unit, words = RESPONSES[load.kind]
        values = [row.responses.get(load.name, np.nan) if row.converged else np.nan for row in rows]
        variables[f"{RESPONSE}{load.name}"] = (
            "prestretch", np.array(values), {"units": unit, "long_name": f"{load.name}: {words}"},
        )  # fmt: skip
        if load.kind == "displacement":
            variables[f"{REACHED}{load.name}"] = (
                "prestretch", _reached(load, mesh, rows),
                {"units": "m", "long_name": f"{load.name}: mean displacement along it"},
            )  # fmt: skip
    return variables


def _reached(load: Load, mesh: PlanarMesh, rows: Sequence[MilestoneState]) -> NDArray[np.float64]:
    """Return the mean displacement of a part of the reference surface, m."""
    nodes, shares = node_shares(load.part, mesh, f"loads.{load.name}.where")
    flat = np.pad(mesh.points[nodes], ((0, 0), (0, 1)))
    moved = np.array([row.position[nodes] - flat for row in rows])
    mean = np.einsum("kij,i,j->k", moved, shares, np.array(load.direction))
    return np.where([row.converged for row in rows], mean, np.nan)


def responses_of(row: xr.Dataset) -> dict[str, float]:
    """Return the responses of a single milestone of a result, by the names of the loads."""
    names = [str(name) for name in row.data_vars if str(name).startswith(RESPONSE)]
    return {name.removeprefix(RESPONSE): float(row[name]) for name in names}
