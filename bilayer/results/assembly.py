"""A result put together: from what a solver found at each milestone to the dataset."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.measures.milestone import Measures, measure
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.layer_variables import body_name, layer_variables, surface_name
from bilayer.results.load_variables import load_coordinates, response_variables
from bilayer.results.schema import FORMAT, SCHEMA_VERSION, MilestoneState
from bilayer.runtime.version import git_commit, own_versions
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.settings import settings_to_toml
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import specimen_to_toml


@dataclass(frozen=True)
class Provenance:
    """The program and settings that make a result, recorded before it is made.

    Parameters
    ----------
    solver, model : str
        Names as in `bilayer.solvers.registry`.
    settings : str
        As TOML text.
    versions : str
        Of this package and of those that compute.
    git_commit : str
        Of the checkout, or an empty text.
    """

    solver: str
    model: str
    settings: str
    versions: str
    git_commit: str

    @classmethod
    def found(
        cls, solver: str, model: str, settings: Any, versions: Mapping[str, str]
    ) -> "Provenance":
        """Return the provenance of results that are made now.

        Parameters
        ----------
        solver, model : str
            Names as in `bilayer.solvers.registry`.
        settings : settings dataclass
            Of that model.
        versions : mapping
            Versions of the packages that compute.
        """
        listed = {**own_versions(), **versions}
        return cls(
            solver,
            model,
            settings_to_toml(settings),
            ", ".join(f"{name} {version}" for name, version in listed.items()),
            git_commit(),
        )


def build_result(
    specimen: Specimen,
    mesh: PlanarMesh,
    states: Sequence[MilestoneState],
    provenance: Provenance,
    *,
    stop_reason: str = "",
    extra: xr.Dataset | None = None,
) -> xr.Dataset:
    """Assemble the dataset of one run.

    Parameters
    ----------
    specimen, mesh
        What was solved, on which planar mesh.
    states : sequence of MilestoneState
        One per milestone of the specimen, in its order; fewer if the run stopped early. Those that
        are not measured yet are measured here.
    provenance : Provenance
        What made it.
    stop_reason : str
        Why milestones are missing, in one line.
    extra : Dataset, optional
        Further variables of the solver (volume fields), merged in.

    Returns
    -------
    Dataset
        With the names of the schema, units and CF/UGRID attributes.
    """
    milestones = specimen.prestretch.milestones
    waiting = MilestoneState(np.full((len(mesh.points), 3), np.nan), False, math.nan)
    known = [
        _measured(specimen, mesh, stretch, state)
        for stretch, state in zip(milestones, states, strict=False)
    ]
    rows = [*known, *[waiting] * (len(milestones) - len(states))]
    result = xr.Dataset(
        {
            **_planar_variables(specimen, mesh),
            **layer_variables(specimen, mesh),
            **_position_variables(surface_name(specimen), rows),
            **_measure_variables(rows),
            **_count_variables(rows),
            **response_variables(specimen, mesh, rows),
        },
        coords=_coordinates(specimen),
        attrs={
            "Conventions": "CF-1.11 UGRID-1.0",
            "title": f"Released shape of the {body_name(specimen)} {specimen.name!r}",
            "history": f"computed by {provenance.solver}, model {provenance.model}",
            "format": FORMAT,
            "schema_version": SCHEMA_VERSION,
            "solver": provenance.solver,
            "model": provenance.model,
            "specimen": specimen_to_toml(specimen),
            "reference_surface": str(specimen.reference_surface),
            "settings": provenance.settings,
            "versions": provenance.versions,
            "git_commit": provenance.git_commit,
            "stop_reason": stop_reason,
        },
    )
    return result if extra is None else result.merge(extra)


def _measured(
    specimen: Specimen, mesh: PlanarMesh, stretch: StretchPair, state: MilestoneState
) -> MilestoneState:
    """Return a state with the measures of its shape."""
    if state.measures is not None:
        return state
    if not state.converged:
        return replace(state, measures=Measures.undefined())
    return replace(state, measures=measure(specimen, mesh, stretch, state.position))


def _coordinates(specimen: Specimen) -> dict[str, Any]:
    pairs = np.array(specimen.prestretch.milestones)
    layers = " and the ".join(specimen.stretched_layers) or "layers"
    note = f"stretch of the {layers} when bonded"
    return {
        "prestretch": (
            "prestretch",
            np.array(specimen.prestretch.nominal),
            {"units": "1", "long_name": f"{note}, the larger of the two directions"},
        ),
        "prestretch_x": (
            "prestretch",
            pairs[:, 0],
            {"units": "1", "long_name": f"{note}, along x"},
        ),
        "prestretch_y": (
            "prestretch",
            pairs[:, 1],
            {"units": "1", "long_name": f"{note}, along y"},
        ),
        **load_coordinates(specimen),
        "xyz": ("xyz", ["x", "y", "z"]),
        **_times(specimen),
    }


def _times(specimen: Specimen) -> dict[str, Any]:
    """Return the time of each milestone, if the specimen has milestones of time."""
    if specimen.schedule is None:
        return {}
    text = "time after the release"
    times = np.array(specimen.schedule.milestones)
    return {"time": ("prestretch", times, {"units": "s", "long_name": text})}


def _planar_variables(specimen: Specimen, mesh: PlanarMesh) -> dict[str, Any]:
    surface = surface_name(specimen)
    flat = np.column_stack([mesh.points, np.zeros(len(mesh.points))])
    return {
        "midsurface": (
            (),
            np.int32(0),
            {
                "cf_role": "mesh_topology",
                "topology_dimension": np.int32(2),
                "node_coordinates": "reference_x reference_y",
                "face_node_connectivity": "face_nodes",
                "long_name": f"the {surface} as a triangle mesh",
            },
        ),
        "reference_x": ("node", mesh.points[:, 0], _metres(f"x of the flat {surface}")),
        "reference_y": ("node", mesh.points[:, 1], _metres(f"y of the flat {surface}")),
        "reference_position": (("node", "xyz"), flat, _metres(f"flat {surface}")),
        "face_nodes": (
            ("face", "corner"),
            mesh.triangles.astype(np.int32),
            {"cf_role": "face_node_connectivity", "start_index": np.int32(0)},
        ),
    }


def _position_variables(surface: str, rows: Sequence[MilestoneState]) -> dict[str, Any]:
    dims = ("prestretch", "node", "xyz")
    on_nodes = {"mesh": "midsurface", "location": "node"}
    nowhere = np.full_like(rows[0].position, np.nan)
    reached = np.array([row.position if row.converged else nowhere for row in rows])
    variables: dict[str, Any] = {
        "position": (dims, reached, _metres(f"released {surface}") | on_nodes)
    }
    if not all(row.converged for row in rows):
        last = np.array([nowhere if row.converged else row.position for row in rows])
        at = np.array([math.nan if row.converged else row.reached for row in rows])
        note = "last shape computed on the way to a milestone that was not reached"
        variables["last_position"] = (dims, last, _metres(note) | on_nodes)
        variables["last_prestretch"] = (
            "prestretch", at, {"units": "1", "long_name": "prestretch of last_position"},
        )  # fmt: skip
    return variables


def _measure_variables(rows: Sequence[MilestoneState]) -> dict[str, Any]:
    measures = [row.measures or Measures.undefined() for row in rows]
    gaps = np.array([measure.self_contact_gap for measure in measures])

    def column(name: str) -> NDArray[np.float64]:
        return np.array([getattr(measure.shape, name) for measure in measures])

    one = {"units": "1"}
    near = "smallest distance of the body from itself where it is bent back, 0 touching"
    return {
        "quality": ("prestretch", column("quality"),
                    one | {"long_name": "distance from a hemisphere: 0 hemisphere, 1 flat"}),
        "sphere_radius": ("prestretch", column("sphere_radius"), _metres("radius of best sphere")),
        "sphere_rmse": ("prestretch", column("sphere_rmse"), _metres("rms distance to it")),
        "hemisphere_distance": (
            "prestretch", column("hemisphere_distance"),
            one | {"long_name": "distance to the hemisphere of equal meridian, relative"},
        ),
        "span": (("prestretch", "xyz"), column("span"), _metres("extent in the body frame")),
        "height": ("prestretch", column("height"), _metres("extent along the body's axis")),
        "self_contact_gap": (
            "prestretch", gaps, _metres(f"{near}, infinite beyond one thickness"),
        ),
    }  # fmt: skip


def _count_variables(rows: Sequence[MilestoneState]) -> dict[str, Any]:
    terms = list(dict.fromkeys(term for row in rows for term in row.energy))
    energy = np.array([[row.energy.get(term, math.nan) for term in terms] for row in rows])

    def column(name: str, kind: type) -> Any:
        return np.array([getattr(row, name) for row in rows], dtype=kind)

    return {
        "energy": (("prestretch", "term"), energy.reshape(len(rows), len(terms)),
                   {"units": "J", "long_name": "energy by term"}),
        "term": ("term", np.array(terms, dtype=object)),
        "iterations": ("prestretch", column("iterations", np.int32),
                       {"long_name": "Newton iterations"}),
        "load_steps": ("prestretch", column("load_steps", np.int32),
                       {"long_name": "load or time steps"}),
        "residual": ("prestretch", column("residual", float),
                     {"units": "1", "long_name": "final relative residual"}),
        "unstable_modes": ("prestretch", column("unstable_modes", np.int32),
                           {"long_name": "number of unstable modes, -1 unknown"}),
        "converged": ("prestretch", column("converged", np.int32),
                      {"long_name": "whether the milestone was reached"}),
        "wall_time": ("prestretch", column("wall_time", float),
                      {"units": "s", "long_name": "time spent"}),
    }  # fmt: skip


def _metres(long_name: str) -> dict[str, str]:
    return {"units": "m", "long_name": long_name}
