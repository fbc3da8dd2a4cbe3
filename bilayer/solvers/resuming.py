"""A run that goes on from the file of one that was not finished."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from bilayer.errors import InputError
from bilayer.measures.milestone import Measures
from bilayer.measures.shape import ShapeMeasures
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.files import ResumePoint, open_result, open_resume_point
from bilayer.results.load_variables import responses_of
from bilayer.results.schema import (
    NOT_MEASURED,
    SAME_STRETCH,
    MilestoneState,
    result_mesh,
    result_specimen,
)
from bilayer.results.table import stretches
from bilayer.specimen.settings import settings_from, settings_to_toml
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.toml import specimen_to_toml
from bilayer.specimen.toml_text import parse_toml


@dataclass(frozen=True, eq=False)
class Unfinished:
    """A run that was not finished.

    Parameters
    ----------
    result : Dataset
        Its milestones so far.
    point : ResumePoint
        The place from which it can be resumed.
    """

    result: xr.Dataset
    point: ResumePoint

    @property
    def mesh(self) -> PlanarMesh:
        """The planar mesh that it is on."""
        return result_mesh(self.result)

    @property
    def states(self) -> list[MilestoneState]:
        """The milestones that are over."""
        return milestone_states(self.result, self.point.tried)

    @property
    def not_measured(self) -> list[str]:
        """The shapes that could not be measured, each with the reason."""
        text = self.result.attrs.get(NOT_MEASURED, "")
        return text.split("; ") if text else []


def milestone_states(result: xr.Dataset, count: int) -> list[MilestoneState]:
    """Return the first milestones of a result, as they were put into it."""
    return [_state(result.isel(prestretch=place)) for place in range(count)]


def _state(row: xr.Dataset) -> MilestoneState:
    converged = bool(row["converged"])
    position = row["position" if converged else "last_position"].values
    energy = row["energy"].values
    return MilestoneState(
        position,
        converged,
        reached=float(row["prestretch" if converged else "last_prestretch"]),
        energy={
            str(term): float(value)
            for term, value in zip(row["term"].values, energy, strict=True)
            if not np.isnan(value)
        },
        iterations=int(row["iterations"]),
        load_steps=int(row["load_steps"]),
        residual=float(row["residual"]),
        wall_time=float(row["wall_time"]),
        unstable_modes=int(row["unstable_modes"]),
        measures=Measures(
            ShapeMeasures(
                quality=float(row["quality"]),
                sphere_radius=float(row["sphere_radius"]),
                sphere_rmse=float(row["sphere_rmse"]),
                hemisphere_distance=float(row["hemisphere_distance"]),
                span=row["span"].values,
                height=float(row["height"]),
            ),
            float(row["self_contact_gap"]),
        ),
        responses=responses_of(row),
    )


def open_unfinished(path: str | Path) -> Unfinished | None:
    """Return the run of a result file that was not finished; None if it was.

    Raises
    ------
    InputError
        The file cannot be read.
    """
    point = open_resume_point(path)
    if point is None:
        return None
    result = open_result(path)
    _check_states(path, result, point.tried)
    return Unfinished(result, point)


def _check_states(path: str | Path, result: xr.Dataset, tried: int) -> None:
    """Raise InputError unless a result holds all that `milestone_states` takes."""
    count = result.sizes["prestretch"]
    if tried > count:
        raise InputError(f"result file {path}: tried = {tried}, expected at most {count}")
    names = ["energy", "term", "self_contact_gap"]
    if not result["converged"].values[:tried].all():
        names += ["last_position", "last_prestretch"]
    missing = [name for name in names if name not in result]
    if missing:
        raise InputError(f"result file {path}: the variable {missing[0]!r} is missing")


def check_same_run(
    result: xr.Dataset,
    path: str | Path,
    specimen: Specimen,
    solver: str,
    model: str,
    settings: Any,
    mesh: PlanarMesh | None,
) -> None:
    """Raise InputError unless a file is of the run that is asked for.

    Its milestones are the first ones of the specimen's, or all.

    Parameters
    ----------
    result : Dataset
        Read from the file.
    path : path-like
        The file.
    specimen, solver, model, settings
        What is to be computed.
    mesh : PlanarMesh or None
        On which mesh; None: on that of the file.
    """
    for name, mine, other in (
        ("solver", solver, result.attrs["solver"]),
        ("model", model, result.attrs["model"]),
        ("settings", settings_to_toml(settings), _settings_text(result, type(settings))),
        ("specimen", _text(specimen, specimen), _text(result_specimen(result), specimen)),
    ):
        if mine != other:
            line = _first_difference(mine, other)
            raise InputError(
                f"result file {path}: was begun with another {name} ({line}), "
                "expected the one that is asked for now"
            )
    if mesh is not None and not result_mesh(result).same_as(mesh):
        raise InputError(f"result file {path}: is on another planar mesh than the one given")
    _check_milestones(path, stretches(result), specimen)


def _check_milestones(
    path: str | Path, pairs: Sequence[Any] | np.ndarray, specimen: Specimen
) -> None:
    wanted = np.array(specimen.prestretch.milestones)
    held = np.asarray(pairs)
    if len(held) != len(wanted) or np.abs(held - wanted).max() > SAME_STRETCH:
        raise InputError(
            f"result file {path}: was begun with the milestones {held.max(axis=1).tolist()}, "
            f"expected those that are asked for now, {specimen.prestretch.nominal}"
        )


def _text(specimen: Specimen, with_milestones_of: Specimen) -> str:
    milestones = with_milestones_of.prestretch.milestones
    return specimen_to_toml(specimen.with_milestones(milestones))


def settings_of(result: xr.Dataset, kind: Any) -> Any:
    """Return the settings of a file; those that its version did not have yet are the defaults.

    Raises
    ------
    InputError
        Some are not settings of that kind.
    """
    return settings_from(kind, parse_toml(result.attrs["settings"], "settings of the result"))


def _settings_text(result: xr.Dataset, kind: Any) -> str:
    try:
        return settings_to_toml(settings_of(result, kind))
    except InputError:
        return str(result.attrs["settings"])


def _first_difference(mine: str, other: str) -> str:
    """Return the first line of the other text that the first one has not."""
    known = mine.splitlines()
    lines = [line for line in other.splitlines() if line not in known]
    return lines[0] if lines else "a line is missing"
