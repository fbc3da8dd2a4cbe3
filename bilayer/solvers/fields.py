"""The fields of a result, computed when they are asked for.

A result file holds shapes, not strains. The solver that made it finds each equilibrium again from
its shape, which takes a few iterations, and tells the deformation of the layers there. So files do
not grow, solving takes no longer, and files of earlier versions have their fields, too.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.alignment import rms_distance
from bilayer.mechanics.dataset import layer_fields, shape_fields
from bilayer.mechanics.layer_state import LayerState
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import result_mesh, result_specimen
from bilayer.results.starting import Neighbour
from bilayer.results.table import stretches
from bilayer.solvers.contract import Equilibrium, Solver, Start
from bilayer.solvers.registry import solver_named
from bilayer.solvers.rerun import result_settings
from bilayer.solvers.run import follow_with
from bilayer.specimen.settings import check_plain

FOUND_AGAIN = 1e-3
"""Largest rms distance of a shape that is found again, over the characteristic length."""
DISTANCE = "found_again"
"""Variable of the fields that holds this distance."""


def fields(
    result: xr.Dataset,
    other: xr.Dataset | None = None,
    *,
    layers: bool = True,
    trust: bool = False,
) -> xr.Dataset:
    """Compute the fields of a result: strains, stresses, energy density, curvatures, distances.

    Parameters
    ----------
    result : Dataset
        From `bilayer.solve` or `bilayer.open_result`, whole or some of its milestones.
    other : Dataset, optional
        Another result of the same sheet; `distance_to_other` is the distance to it.
    layers : bool
        Whether to compute the fields of the layers, too. They take the solver that made the result
        and about a second (shell) or ten (finite elements) a milestone. The models `hinge` and
        `paper`, and results from other programs, have none.
    trust : bool
        Allow settings that could run code or write files. They come from the result's file.

    Returns
    -------
    Dataset
        With the milestones of the result; docs/fields.md has all variables.

    Raises
    ------
    InputError
        The settings are unknown to this version or not plain, or an equilibrium is not found again.
    ComputationError
        The solver of the result is not installed, or fails.

    Examples
    --------
    >>> import bilayer
    >>> from dataclasses import replace
    >>> specimen = bilayer.paper_specimen().with_milestones([1.03])
    >>> specimen = replace(specimen, mesh=bilayer.MeshSize(0.012))  # coarse: for the example
    >>> result = bilayer.solve(specimen, "dshell")
    >>> found = bilayer.fields(result)
    >>> stress = found["cauchy_stress"].sel(sheet_layer="substrate", level="top")  # Pa
    """
    result = along_milestones(result)
    found = shape_fields(result, other)
    if not layers or not has_layer_fields(result):
        return found
    states, distances = _layer_states(result, trust)
    text = "rms distance of the shape whose fields these are from the one in the result"
    variable = ("prestretch", distances, {"units": "m", "long_name": text})
    return found.merge(layer_fields(result, states)).assign({DISTANCE: variable})


def has_layer_fields(result: xr.Dataset) -> bool:
    """Whether the model of a result has strains and stresses in the layers."""
    try:
        solver, settings = solver_named(result.attrs["solver"]), result_settings(result)
    except InputError:
        return False
    return solver.has_layers(settings)


def _layer_states(
    result: xr.Dataset, trust: bool
) -> tuple[list[Sequence[LayerState] | None], NDArray[np.float64]]:
    """Return the deformation of the layers at each milestone, and how far its shape is away."""
    solver, settings = solver_named(result.attrs["solver"]), result_settings(result)
    if not trust:
        check_plain(settings)
    reached = np.flatnonzero(result["converged"].values == 1)
    states: list[Sequence[LayerState] | None] = [None] * result.sizes["prestretch"]
    distances = np.full(len(states), np.nan)
    if len(reached) == 0:
        return states, distances
    known = result.isel(prestretch=reached)
    mesh, specimen = result_mesh(known), result_specimen(result)
    length = specimen.characteristic_length
    asked = specimen.with_milestones([(x, y) for x, y in stretches(known)])
    found = follow_with(solver, asked, settings, mesh=mesh, start=_start(solver, settings, known))
    milestones = (equilibrium for equilibrium in found if equilibrium.share == 1)
    for place, equilibrium in zip(reached, milestones, strict=True):
        distances[place] = _distance(known, mesh, equilibrium, length)
        states[place] = equilibrium.layer_states()
    return states, distances


def _start(solver: Solver, settings: object, known: xr.Dataset) -> Start:
    return Neighbour(known) if solver.takes_neighbours(settings) else known


def _distance(result: xr.Dataset, mesh: PlanarMesh, found: Equilibrium, length: float) -> float:
    """Return the distance of a shape from the result's, m; raise InputError if it is another."""
    stretch = np.array(found.stretch)
    pairs = np.column_stack([result["prestretch_x"].values, result["prestretch_y"].values])
    rows = np.flatnonzero((np.abs(pairs - stretch) < 1e-9).all(axis=1))
    weights = flat_surface(mesh).node_areas
    shapes = result["position"].values[rows]
    distance = min(rms_distance(found.position, shape, weights) for shape in shapes)
    if distance > FOUND_AGAIN * length:
        raise InputError(
            f"prestretch = {stretch.max():g}: the equilibrium found again is {distance:.3g} m "
            f"(rms) from the shape in the result, expected at most {FOUND_AGAIN * length:.3g} m"
        )
    return distance
