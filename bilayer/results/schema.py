"""The schema of a result: one xarray dataset for all solvers, and nothing else between them.

Dimensions `prestretch` (the milestones, in the order in which the path took them: a value may come
again), `node`, `face`, `xyz`. `position` is the reference surface on the nodes of the planar mesh.
Milestones that were not reached are NaN with `converged` = 0; the attribute `stop_reason` says why,
and `last_position` holds the last shape computed on the way to each, at the prestretch
`last_prestretch`.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.measures.milestone import Measures
from bilayer.mesh.planar import PlanarMesh
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import parse_specimen

SCHEMA_VERSION = 1
FORMAT = "bilayer-shells result"
REQUIRED = {
    "attribute": (
        "specimen", "settings", "solver", "model", "versions", "git_commit", "stop_reason",
    ),
    "variable": (
        "prestretch", "prestretch_x", "prestretch_y", "reference_position", "face_nodes", "region",
        "position", "quality", "sphere_radius", "sphere_rmse", "hemisphere_distance", "span",
        "height", "iterations", "load_steps", "residual", "unstable_modes", "converged",
        "wall_time",
    ),
}  # fmt: skip
"""The attributes and variables of every result file, whatever made it."""
NOT_MEASURED = "not_measured"
"""Attribute of a result of which a shape could not be measured: which, and why."""
CONTACT_CROSSES = "contact_crosses"
"""Variable of a result whose contact was modelled: 1 if the skin crosses itself all the same."""
TIMES_FOUND = "times_found"
"""Variable of the states of a search (`bilayer.landscape`): how often each was found."""
LOWER_STATE = "lower_state"
"""Variable of a result for which lower states were looked for: how far the lowest lies below."""
UNKNOWN_STABILITY = -1
SAME_STRETCH = 1e-9
"""Milestones that differ by less are the same."""


@dataclass(frozen=True)
class MilestoneState:
    """The state at one milestone.

    Parameters
    ----------
    position : (n, 3) array of float
        The reference surface, m: the equilibrium if `converged`, else the last shape computed.
    converged : bool
        Whether the milestone was reached.
    reached : float
        The prestretch of `position`: the milestone's, or where the run stopped.
    energy : mapping of str to float
        Energy terms, J.
    iterations : int
        Newton iterations, each with one factorisation, spent on this milestone.
    load_steps : int
        Load or time steps spent on this milestone.
    residual : float
        Final residual norm, relative to the solver's own reference.
    wall_time : float
        Seconds spent on this milestone.
    unstable_modes : int
        Number of unstable modes; -1 if the method cannot tell.
    measures : Measures or None
        Of the shape; None: not measured yet.
    responses : mapping of str to float
        What each load does its work on, by its name.
    """

    position: NDArray[np.float64]
    converged: bool
    reached: float
    energy: Mapping[str, float] = field(default_factory=dict)
    iterations: int = 0
    load_steps: int = 0
    residual: float = math.nan
    wall_time: float = math.nan
    unstable_modes: int = UNKNOWN_STABILITY
    measures: Measures | None = None
    responses: Mapping[str, float] = field(default_factory=dict)


def result_specimen(result: xr.Dataset) -> Specimen:
    """Return the specimen that a result was computed for.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> bilayer.result_specimen(result) == specimen
    True
    """
    return parse_specimen(result.attrs["specimen"], source="the result's specimen")


def result_mesh(result: xr.Dataset) -> PlanarMesh:
    """Return the planar mesh that a result was computed on.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> len(bilayer.result_mesh(result).points) == result.sizes["node"]
    True
    """
    return PlanarMesh(
        result["reference_position"].values[:, :2],
        result["face_nodes"].values,
        result["region"].values,
        result_specimen(result).layer_sets,
    )
