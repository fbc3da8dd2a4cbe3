"""The states of a search as a result: a milestone for each, all at the same prestretch.

So whatever reads a result reads states. The variables that it has more stand in `VARIABLES`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.landscape.catalogue import NOWHERE, Catalogue, State, chance_of_another
from bilayer.landscape.symmetry import Images
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.schema import TIMES_FOUND, MilestoneState
from bilayer.solvers.resuming import milestone_states
from bilayer.specimen.outline import Symmetry
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

VARIABLES = {
    TIMES_FOUND: ("1", "finds of the state"),
    "found_as": ("1", "place of the state in the order of the finds"),
    "least_stiffness": ("N m-3", "least eigenvalue of the stiffness over the flat area"),
    "next_stiffness": ("N m-3", "the eigenvalue after it"),
    "symmetry_turns": ("1", "turns of the sheet in its plane that leave the state as it is"),
    "symmetry_mirrored": ("1", "whether mirroring the sheet in its plane does"),
    "turned_over": ("1", "the state that is this one turned over, -1 none"),
    "start_name": ("", "starts of the search"),
    "start_state": ("1", "the lowest state that each led to, -1 none"),
}
"""Unit and description of the variables of a search."""
CHANCE = "chance_of_another_state"
"""Attribute: the estimated chance that one more start finds a state that is not known."""
ASKED = "starts_asked"
"""Attribute: the starts of the whole search."""


def states_dataset(
    specimen: Specimen,
    stretch: StretchPair,
    mesh: PlanarMesh,
    catalogue: Catalogue,
    provenance: Provenance,
    asked: int,
    stop_reason: str = "",
) -> xr.Dataset:
    """Return the states of a search, the lowest first; see `bilayer.results.schema`.

    Parameters
    ----------
    specimen, stretch, mesh
        What was searched, at which prestretch, on which planar mesh.
    catalogue : Catalogue
        The states, at least one.
    provenance : Provenance
        What found them.
    asked : int
        Starts of the whole search.
    stop_reason : str
        Why it ended before, in one line.
    """
    order = catalogue.order()
    states = [catalogue.states[place] for place in order]
    result = build_result(
        specimen.with_milestones([stretch] * len(states)),
        mesh,
        [state.milestone for state in states],
        provenance,
        stop_reason=stop_reason,
    )
    values = _of_states(catalogue, order, states) | _of_starts(catalogue, order)
    found = np.array([state.times_found for state in states])
    done = len(catalogue.visits)
    result.attrs |= {
        "title": result.attrs["title"].replace("Released shape", "Stable shapes"),
        "start": f"{done} starts of a search",
        CHANCE: chance_of_another(found, done),
        ASKED: asked,
    }
    return result.assign({name: _described(name, *value) for name, value in values.items()})


def _described(name: str, dims: str, values: Any) -> Any:
    units, text = VARIABLES[name]
    return dims, values, {"long_name": text} | ({"units": units} if units else {})


def _of_states(
    catalogue: Catalogue, order: Sequence[int], states: Sequence[State]
) -> dict[str, tuple[str, Any]]:
    whole = {
        TIMES_FOUND: [state.times_found for state in states],
        "found_as": order,
        "symmetry_turns": [state.symmetry.turns for state in states],
        "symmetry_mirrored": [state.symmetry.mirrored for state in states],
        "turned_over": [_row(order, _turned_over(catalogue, state)) for state in states],
    }
    stiffness = np.array([state.stiffness for state in states])
    return {
        **{name: ("prestretch", np.array(column, np.int32)) for name, column in whole.items()},
        "least_stiffness": ("prestretch", stiffness[:, 0]),
        "next_stiffness": ("prestretch", stiffness[:, 1]),
    }


def _turned_over(catalogue: Catalogue, state: State) -> int | None:
    return catalogue.place_of(state.position * [1.0, 1.0, -1.0], state.energy)


def _of_starts(catalogue: Catalogue, order: Sequence[int]) -> dict[str, tuple[str, Any]]:
    names = np.array([name for name, _ in catalogue.visits], dtype=object)
    lowest = [
        min((_row(order, place) for place in places), default=NOWHERE)
        for _, places in catalogue.visits
    ]
    return {"start_name": ("start", names), "start_state": ("start", np.array(lowest, np.int32))}


def _row(order: Sequence[int], place: int | None) -> int:
    return NOWHERE if place is None else list(order).index(place)


def read_catalogue(result: xr.Dataset, images: Images, length: float) -> Catalogue:
    """Return the catalogue of a search that was written, for one that goes on.

    Parameters
    ----------
    result : Dataset
        See `states_dataset`.
    images : Images
        Under the symmetry of the specimen.
    length : float
        Its characteristic length, m.

    Raises
    ------
    InputError
        It holds no states of a search.
    """
    missing = [name for name in VARIABLES if name not in result]
    if missing:
        raise InputError(f"{missing[0]}: is missing, expected the states of a search")
    milestones = milestone_states(result, result.sizes["prestretch"])
    rows = np.argsort(result["found_as"].values)
    states = [_state(milestones[row], result.isel(prestretch=row)) for row in rows]
    catalogue = Catalogue(images, length, states)
    place_of = {int(row): place for place, row in enumerate(rows)}
    for name, row in zip(result["start_name"].values, result["start_state"].values, strict=True):
        catalogue.visits.append((str(name), () if row == NOWHERE else (place_of[int(row)],)))
    return catalogue


def _state(milestone: MilestoneState, row: xr.Dataset) -> State:
    stiffness = np.array([row["least_stiffness"], row["next_stiffness"]], dtype=float)
    symmetry = Symmetry(int(row["symmetry_turns"]), bool(row["symmetry_mirrored"]))
    return State(milestone, stiffness, symmetry, int(row[TIMES_FOUND]))
