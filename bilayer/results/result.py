"""A result: one xarray dataset for both solvers, written as NetCDF, and nothing else between them.

Dimensions `prestretch` (the milestones), `node`, `face`, `xyz`. `position` is the bonded
interface on the nodes of the planar mesh. Milestones that were not reached are NaN with
`converged` = 0; the attribute `stop_reason` says why, and `last_position` holds the last shape
computed on the way to each, at the prestretch `last_prestretch`.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.contact.self_contact import BondedBody, self_contact_gap
from bilayer.errors import InputError
from bilayer.measures.shape import ShapeMeasures, measure_shape
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.milestones import along_milestones
from bilayer.runtime.output_file import HDF5_ROOM, whole_file
from bilayer.runtime.version import git_commit, own_versions
from bilayer.specimen.settings import settings_to_toml
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import parse_specimen, specimen_to_toml

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
"""What a file of ours holds, whatever made it."""
UNKNOWN_STABILITY = -1
SAME_STRETCH = 1e-9
"""Milestones that differ by less are the same."""


@dataclass(frozen=True)
class MilestoneState:
    """What a solver found at one milestone.

    Parameters
    ----------
    position : (n, 3) array of float
        The bonded interface, m: the equilibrium where `converged`, else the last shape computed.
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
        Number of unstable modes; -1 where the method cannot tell.
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


def build_result(
    specimen: Specimen,
    mesh: PlanarMesh,
    states: Sequence[MilestoneState],
    *,
    solver: str,
    model: str,
    settings: Any,
    versions: Mapping[str, str],
    stop_reason: str = "",
    extra: xr.Dataset | None = None,
) -> xr.Dataset:
    """Assemble the dataset of one run.

    Parameters
    ----------
    specimen, mesh
        What was solved, on which planar mesh.
    states : sequence of MilestoneState
        One per milestone of the specimen, in its order; fewer where the run stopped early.
    solver, model : str
        Names as in `bilayer.solvers.registry`.
    settings : settings dataclass
        Kept as TOML text.
    versions : mapping
        Versions of the packages that computed it.
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
    rows = [*states, *[waiting] * (len(milestones) - len(states))]
    result = xr.Dataset(
        {
            **_planar_variables(mesh),
            **_position_variables(rows),
            **_measure_variables(mesh, rows),
            **_contact_variables(specimen, mesh, rows),
            **_count_variables(rows),
        },
        coords=_coordinates(specimen),
        attrs={
            "Conventions": "CF-1.11 UGRID-1.0",
            "title": f"Released shape of the bilayer {specimen.name!r}",
            "history": f"computed by {solver}, model {model}",
            "format": FORMAT,
            "schema_version": SCHEMA_VERSION,
            "solver": solver,
            "model": model,
            "specimen": specimen_to_toml(specimen),
            "settings": settings_to_toml(settings),
            "versions": ", ".join(f"{k} {v}" for k, v in {**own_versions(), **versions}.items()),
            "git_commit": git_commit(),
            "stop_reason": stop_reason,
        },
    )
    return result if extra is None else result.merge(extra)


def write_result(result: xr.Dataset, path: str | Path) -> None:
    """Write a dataset as NetCDF, whole or not at all.

    Raises
    ------
    InputError
        The folder does not exist or cannot be written.
    ComputationError
        Writing failed, for example on a full disk; an earlier file of that name stays as it was.
    """
    packed: dict[Any, dict[str, Any]] = {
        name: {"zlib": True, "complevel": 4}
        for name, variable in result.variables.items()
        if variable.dtype.kind == "f" and variable.ndim > 1
    }
    without_gaps = {name: {"_FillValue": None} for name in result.coords}  # CF, section 2.5.1
    with whole_file(path, "result file", room=result.nbytes + HDF5_ROOM) as partial:
        result.to_netcdf(partial, engine="netcdf4", encoding=packed | without_gaps)


def open_result(path: str | Path) -> xr.Dataset:
    """Read a result into memory.

    Raises
    ------
    InputError
        The file is missing, is no dataset of this project, or has a newer schema.
    """
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            result = stored.load()
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(
            f"result file {path}: cannot be read ({_why_unreadable(Path(path))})"
        ) from error
    if result.attrs.get("format") != FORMAT:
        raise InputError(
            f"result file {path}: format = {result.attrs.get('format')!r}, expected {FORMAT!r}"
        )
    _check_schema(path, result.attrs.get("schema_version"))
    for part, held in (("attribute", result.attrs), ("variable", result.variables)):
        missing = [name for name in REQUIRED[part] if name not in held]
        if missing:
            raise InputError(f"result file {path}: the {part} {missing[0]!r} is missing")
    return result


def _why_unreadable(path: Path) -> str:
    if path.is_dir():
        return "is a folder"
    return "not a whole NetCDF file" if path.exists() else "no such file"


def _check_schema(path: str | Path, found: Any) -> None:
    field = f"result file {path}: schema_version = {found}"
    if not isinstance(found, (int, np.integer)):
        raise InputError(f"{field}, expected a whole number up to {SCHEMA_VERSION}")
    if found > SCHEMA_VERSION:
        raise InputError(
            f"{field}, expected at most {SCHEMA_VERSION}: made by a newer version of this package"
        )


def result_specimen(result: xr.Dataset) -> Specimen:
    """Return the specimen that a result was computed for."""
    return parse_specimen(result.attrs["specimen"], source="the result's specimen")


def result_mesh(result: xr.Dataset) -> PlanarMesh:
    """Return the planar mesh that a result was computed on."""
    return PlanarMesh(
        result["reference_position"].values[:, :2],
        result["face_nodes"].values,
        result["region"].values,
    )


def starting_shape(start: xr.Dataset, mesh: PlanarMesh, prestretch: float) -> NDArray[np.float64]:
    """Return the shape of a result at its milestone nearest to a prestretch.

    Returns
    -------
    (n, 3) array of float
        The bonded interface, m.

    Raises
    ------
    InputError
        The result is on another planar mesh, or reached no milestone.
    """
    if not result_mesh(start).same_as(mesh):
        raise InputError(
            f"start: has {start.sizes['node']} nodes and {start.sizes['face']} triangles of its own"
            f", expected a result on the planar mesh of this run ({len(mesh.points)} nodes)"
        )
    start = along_milestones(start)
    reached = np.flatnonzero(start["converged"].values == 1)
    if len(reached) == 0:
        raise InputError("start: has no converged milestone, expected at least one")
    apart = np.abs(start["prestretch"].values[reached] - prestretch)
    shape: NDArray[np.float64] = start["position"].values[reached[np.argmin(apart)]]
    return shape


def _coordinates(specimen: Specimen) -> dict[str, Any]:
    pairs = np.array(specimen.prestretch.milestones)
    note = f"stretch of the {' and the '.join(specimen.stretched_layers)} when bonded"
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
        "xyz": ("xyz", ["x", "y", "z"]),
    }


def _planar_variables(mesh: PlanarMesh) -> dict[str, Any]:
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
                "long_name": "the bonded interface as a triangle mesh",
            },
        ),
        "reference_x": ("node", mesh.points[:, 0], _metres("x of the flat bonded interface")),
        "reference_y": ("node", mesh.points[:, 1], _metres("y of the flat bonded interface")),
        "reference_position": (("node", "xyz"), flat, _metres("flat bonded interface")),
        "face_nodes": (
            ("face", "corner"),
            mesh.triangles.astype(np.int32),
            {"cf_role": "face_node_connectivity", "start_index": np.int32(0)},
        ),
        "region": (
            "face",
            mesh.region.astype(np.int32),
            {
                "long_name": "layers of the face",
                "flag_values": np.array([0, 1], dtype=np.int32),
                "flag_meanings": "bare kirigami",
                "mesh": "midsurface",
                "location": "face",
            },
        ),
    }


def _position_variables(rows: Sequence[MilestoneState]) -> dict[str, Any]:
    dims = ("prestretch", "node", "xyz")
    on_nodes = {"mesh": "midsurface", "location": "node"}
    nowhere = np.full_like(rows[0].position, np.nan)
    reached = np.array([row.position if row.converged else nowhere for row in rows])
    variables: dict[str, Any] = {
        "position": (dims, reached, _metres("released bonded interface") | on_nodes)
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


def _measure_variables(mesh: PlanarMesh, rows: Sequence[MilestoneState]) -> dict[str, Any]:
    measures = [
        measure_shape(mesh, row.position) if row.converged else ShapeMeasures.undefined()
        for row in rows
    ]

    def column(name: str) -> NDArray[np.float64]:
        return np.array([getattr(measure, name) for measure in measures])

    one = {"units": "1"}
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
    }  # fmt: skip


def _contact_variables(
    specimen: Specimen, mesh: PlanarMesh, rows: Sequence[MilestoneState]
) -> dict[str, Any]:
    gaps = [
        self_contact_gap(BondedBody.of(specimen, mesh, stretch), row.position)
        if row.converged
        else math.nan
        for stretch, row in zip(specimen.prestretch.milestones, rows, strict=True)
    ]
    note = "smallest distance of the body from itself where it is bent back, 0 touching"
    return {
        "self_contact_gap": (
            "prestretch", np.array(gaps), _metres(f"{note}, infinite beyond one thickness"),
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
