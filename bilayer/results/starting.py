"""What a run starts from: another result on the same planar mesh, made on purpose or read.

A start holds shapes along the way: at milestones of the run, or between them. The accurate shell
makes them in seconds (`shell_start`), and a solver that goes there takes few iterations.
"""

import math
from collections.abc import Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.mesh.planar import PlanarMesh
from bilayer.results.start_shapes import StartShapes, way_length
from bilayer.specimen.specimen import Specimen

LONGEST_WAY = 0.06
"""Change of the prestretch after which a start has another shape on the way to a milestone."""

FLAT = "flat"
ANOTHER_RESULT = "another result: "
"""How a result says what it was started from: flat (and how, on a fine mesh of the shell), by
another result, or by itself (the shell)."""

Stretch = tuple[float, float]


def starting_shape(start: xr.Dataset, mesh: PlanarMesh, stretch: Stretch) -> NDArray[np.float64]:
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
    return StartShapes.of(start, mesh).nearest(stretch).shape


def with_waypoints(specimen: Specimen) -> Specimen:
    """Return the specimen with milestones added where two are far apart in prestretch."""
    milestones: list[Stretch] = []
    for begin, end in _ways(specimen.prestretch.milestones):
        pieces = max(1, math.ceil(way_length(begin, end) / LONGEST_WAY * (1 - 1e-9)))
        milestones += [_between(begin, end, piece / pieces) for piece in range(1, pieces)]
        milestones.append(end)
    return specimen.with_milestones(milestones)


def began(start: xr.Dataset | None) -> str:
    """Return what a result says of what it was told to start from."""
    return FLAT if start is None else ANOTHER_RESULT + described(start)


def described(start: xr.Dataset) -> str:
    """Return in a line what a start is and what it took."""
    iterations, seconds = int(start["iterations"].sum()), float(start["wall_time"].sum())
    return (
        f"{start.attrs['solver']}, model {start.attrs['model']}, "
        f"{iterations} iterations in {seconds:.1f} s"
    )


def _ways(milestones: Sequence[Stretch]) -> list[tuple[Stretch, Stretch]]:
    return list(zip([(1.0, 1.0), *milestones[:-1]], milestones, strict=True))


def _between(begin: Stretch, end: Stretch, share: float) -> Stretch:
    x, y = (a + share * (b - a) for a, b in zip(begin, end, strict=True))
    return x, y
