"""Shapes that CalculiX computed from our decks, as a result in our schema.

`position` is the substrate's side of the interface at the nodes of the planar mesh. Only the end
of the step is a shape of the specimen, see `bilayer.calculix.deck`; a run that stopped before is a
milestone that was not reached, with the reason.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.calculix.deck import MM_PER_M, deck_points
from bilayer.calculix.files import Frd, RunRecord, read_frd, read_run_record
from bilayer.calculix.quadratic_mesh import ELEMENTS
from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.assembly import Provenance, build_result
from bilayer.results.schema import MilestoneState
from bilayer.results.table import stretch_text
from bilayer.specimen.specimen import Specimen

FRD_ROUNDING = 1e-5
"""Error of coordinates in a .frd file, which has six digits, over the largest coordinate."""
WHOLE_STEP = 1 - 1e-6


@dataclass(frozen=True)
class CalculixSettings:
    """Settings of a result that CalculiX computed.

    Parameters
    ----------
    element : {"hexahedron", "wedge"}
        See `bilayer.calculix.deck.DeckSettings`.
    files : sequence of str
        Names of the files that were read.
    """

    element: str
    files: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class _Run:
    """The files of one deck's run, and the milestone they belong to."""

    frd: Frd
    convergence: RunRecord
    milestone: tuple[float, float]
    element: str
    why_not: str

    def state(self, nodes: int) -> MilestoneState:
        """Return the milestone's state, on the first nodes."""
        found = (self.frd.points + self.frd.displacements)[:nodes]
        shape = np.divide(found, MM_PER_M, dtype=np.float64)
        return MilestoneState(
            shape if not self.why_not else np.full_like(shape, np.nan),
            converged=not self.why_not,
            reached=math.nan if self.why_not else max(self.milestone),
            iterations=self.convergence.iterations,
            load_steps=self.convergence.increments,
            residual=self.convergence.residual,
        )


def import_calculix(
    paths: Sequence[str | Path], specimen: Specimen, mesh: PlanarMesh
) -> xr.Dataset:
    """Read the runs of one or more decks of a specimen.

    Parameters
    ----------
    paths : sequence of path-like
        The .frd files, one per prestretch, each with its .sta and .cvg files beside it.
    specimen : Specimen
        What the decks were made of.
    mesh : PlanarMesh
        On which planar mesh.

    Returns
    -------
    Dataset
        Of the milestones that the files are of; see `bilayer.results.schema`.

    Raises
    ------
    InputError
        A file is missing or damaged, belongs to no milestone of the specimen on this mesh, or two
        belong to one, or their elements differ.
    """
    runs = sorted(
        (_read_run(path, specimen, mesh) for path in paths), key=lambda run: max(run.milestone)
    )
    milestones = [run.milestone for run in runs]
    if len(set(milestones)) < len(runs) or len({run.element for run in runs}) > 1:
        found = ", ".join(f"{stretch_text(run.milestone)} ({run.element})" for run in runs)
        raise InputError(f"frd files of the prestretches {found}: expected one of each, all alike")
    return build_result(
        specimen.with_milestones(milestones),
        mesh,
        [run.state(len(mesh.points)) for run in runs],
        Provenance.found(
            "calculix",
            runs[0].element,
            CalculixSettings(runs[0].element, tuple(Path(path).name for path in paths)),
            {"CalculiX": runs[0].frd.version},
        ),
        stop_reason="; ".join(run.why_not for run in runs if run.why_not),
    )


def _read_run(path: str | Path, specimen: Specimen, mesh: PlanarMesh) -> _Run:
    frd, convergence = read_frd(path), read_run_record(path)
    milestone, element = _recognised(path, np.divide(frd.points, MM_PER_M), specimen, mesh)
    why_not = _why_not_reached(milestone, frd, convergence)
    return _Run(frd, convergence, milestone, element, why_not)


def _why_not_reached(milestone: tuple[float, float], frd: Frd, convergence: RunRecord) -> str:
    if convergence.reached >= WHOLE_STEP and frd.is_whole:
        return "" if np.isfinite(frd.displacements).all() else "the .frd file has no displacements"
    failed = convergence.failed_increment
    how = "was ended" if failed is None else f"gave up in increment {failed}"
    return (
        f"prestretch {stretch_text(milestone)}: CalculiX {how} at c = {convergence.reached:.4g}, "
        "where the layers do not fit yet (c = 1)"
    )


def _recognised(
    path: str | Path, points: NDArray[np.float64], specimen: Specimen, mesh: PlanarMesh
) -> tuple[tuple[float, float], str]:
    """Return the milestone and the element of the deck whose nodes are drawn at some points."""
    candidates = [
        (milestone, element) for element in ELEMENTS for milestone in specimen.prestretch.milestones
    ]
    apart = [_distance(points, deck_points(specimen, mesh, *pair)) for pair in candidates]
    best = int(np.argmin(apart))
    if apart[best] > FRD_ROUNDING * np.abs(points).max():
        listed = ", ".join(map(stretch_text, specimen.prestretch.milestones))
        raise InputError(
            f"frd file {path}: its {len(points)} nodes lie where no deck of this specimen on this "
            f"mesh has them (milestones {listed}), expected a result of what bilayer export wrote"
        )
    return candidates[best]


def _distance(found: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    return float(np.abs(found - expected).max()) if found.shape == expected.shape else math.inf
