"""The start of a run: another result on the same planar mesh, computed for it or read.

A start holds shapes at milestones of the run, or between them. The accurate shell computes them in
seconds. A solver that uses them as initial guesses takes few iterations.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.results.start_shapes import StartShapes, way_length
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

LONGEST_WAY = 0.06
"""Change of the prestretch after which a start has another shape on the way to a milestone."""

FLAT_START = "flat"
ANOTHER_RESULT = "another result: "
"""Beginnings of a result's attribute `start`: flat (or, on a fine mesh of the shell, flat on a
coarse mesh first), or another result."""


@dataclass(frozen=True, eq=False)
class Neighbour:
    """A start of a specimen that differs by little: each of its shapes leads to the same milestone.

    Parameters
    ----------
    result : Dataset
        On the same planar mesh, with the same milestones, all of them reached.
    """

    result: xr.Dataset

    def __call__(self, mesh: PlanarMesh) -> xr.Dataset:
        """Return the result, for a solver that takes any start alike."""
        return self.result


def starting_shape(
    start: xr.Dataset, mesh: PlanarMesh, stretch: StretchPair
) -> NDArray[np.float64]:
    """Return the shape of a result at its milestone nearest to a prestretch.

    Returns
    -------
    (n, 3) array of float
        The reference surface, m.

    Raises
    ------
    InputError
        The result is on another planar mesh, or reached no milestone.
    """
    return StartShapes.of(start, mesh).take_nearest(stretch).shape


def with_waypoints(specimen: Specimen) -> Specimen:
    """Return the specimen with milestones added if two are far apart in prestretch.

    One with milestones of time is returned as it is at its release.
    """
    if specimen.schedule is not None:
        return _at_release(specimen)
    milestones: list[StretchPair] = []
    for begin, end in _ways(specimen.prestretch.milestones):
        pieces = max(1, math.ceil(way_length(begin, end) / LONGEST_WAY * (1 - 1e-9)))
        milestones += [_between(begin, end, piece / pieces) for piece in range(1, pieces)]
        milestones.append(end)
    return specimen.with_milestones(milestones)


def _at_release(specimen: Specimen) -> Specimen:
    """Return the specimen with time 0 after its release as its only milestone."""
    assert specimen.schedule is not None
    schedule = replace(specimen.schedule, milestones=(0.0,))
    return replace(specimen.with_milestones(specimen.prestretch.milestones[:1]), schedule=schedule)


def describe_start(start: xr.Dataset | None) -> str:
    """Return the attribute `start` of a result that was given this start."""
    return FLAT_START if start is None else ANOTHER_RESULT + describe_run(start)


def describe_run(start: xr.Dataset) -> str:
    """Return a start in a line: its solver, model, iterations and time."""
    iterations, seconds = int(start["iterations"].sum()), float(start["wall_time"].sum())
    return (
        f"{start.attrs['solver']}, model {start.attrs['model']}, "
        f"{iterations} iterations in {seconds:.1f} s"
    )


def _ways(milestones: Sequence[StretchPair]) -> list[tuple[StretchPair, StretchPair]]:
    return list(zip([(1.0, 1.0), *milestones[:-1]], milestones, strict=True))


def _between(begin: StretchPair, end: StretchPair, share: float) -> StretchPair:
    x, y = (a + share * (b - a) for a, b in zip(begin, end, strict=True))
    return x, y
