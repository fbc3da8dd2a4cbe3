"""What a run starts from: another result on the same planar mesh, made on purpose or read.

A start holds shapes along the way: at milestones of the run, or between them. The accurate shell
makes them in seconds (`shell_start`), and a solver that goes there takes few iterations.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import SAME_STRETCH, result_mesh
from bilayer.results.table import stretches
from bilayer.specimen.specimen import Specimen

LONGEST_WAY = 0.06
"""Change of the prestretch after which a start has another shape on the way to a milestone."""

FLAT = "flat"
ANOTHER_RESULT = "another result: "
"""How a result says what it was started from: flat (and how, on a fine mesh of the shell), by
another result, or by itself (the shell)."""

Stretch = tuple[float, float]


@dataclass(frozen=True, eq=False)
class ShapeOnTheWay:
    """A shape of a start, where it is of use.

    Parameters
    ----------
    milestone : int
        The milestone of the run that it is at, or before.
    remaining : float
        Change of the prestretch from the shape to the milestone, 0 at it.
    shape : (n, 3) array of float
        The bonded interface, m, in any position and orientation.
    """

    milestone: int
    remaining: float
    shape: NDArray[np.float64]


def starting_shape(start: xr.Dataset, mesh: PlanarMesh, stretch: Stretch) -> NDArray[np.float64]:
    """Return the shape of a result at its milestone nearest to a prestretch.

    Nearest in the larger stretch, then in both; the first of those that are as near.

    Returns
    -------
    (n, 3) array of float
        The reference surface, m.

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
    reached = np.flatnonzero(start["converged"].values == 1)
    if len(reached) == 0:
        raise InputError("start: has no converged milestone, expected at least one")
    pairs = stretches(start)[reached]
    nominal = np.abs(pairs.max(axis=1) - max(stretch))
    both = np.abs(pairs - stretch).max(axis=1)
    nearest = reached[np.lexsort((both, nominal))[0]]
    shape: NDArray[np.float64] = start["position"].values[nearest]
    return shape


def with_waypoints(specimen: Specimen) -> Specimen:
    """Return the specimen with milestones added where two are far apart in prestretch."""
    milestones: list[Stretch] = []
    for begin, end in _ways(specimen.prestretch.milestones):
        pieces = max(1, math.ceil(_length(begin, end) / LONGEST_WAY * (1 - 1e-9)))
        milestones += [_between(begin, end, piece / pieces) for piece in range(1, pieces)]
        milestones.append(end)
    return specimen.with_milestones(milestones)


def shapes_on_the_way(
    start: xr.Dataset, mesh: PlanarMesh, milestones: Sequence[Stretch]
) -> list[ShapeOnTheWay]:
    """Return the shapes of a start at the milestones of a run and between them, in their order.

    Where none is at the first milestone or before it, the shape of the nearest prestretch stands
    in for it.

    Raises
    ------
    InputError
        The start is on another planar mesh, or reached no milestone.
    """
    nearest = starting_shape(start, mesh, milestones[0])
    done = start["converged"].values == 1
    pairs, positions = stretches(start)[done], start["position"].values[done]
    found: list[ShapeOnTheWay] = []
    passed = 0
    for milestone, (begin, end) in enumerate(_ways(milestones)):
        rows = _rows_on_way(pairs, begin, end, passed)
        found += [
            ShapeOnTheWay(milestone, (1 - share) * _length(begin, end), positions[row])
            for share, row in rows
        ]
        if rows and rows[-1][0] == 1:
            passed = rows[-1][1]
    if not found or found[0].milestone > 0:
        found.insert(0, ShapeOnTheWay(0, 0.0, nearest))
    return found


def _rows_on_way(
    pairs: NDArray[np.float64], begin: Stretch, end: Stretch, passed: int
) -> list[tuple[float, int]]:
    """Return the share of the way and the row of each prestretch that lies on it, ascending.

    A start that goes up and down passes a prestretch more than once. The rows of a way are those
    from `passed`, the row where it begins, to the first that is at its end. If there is none, all
    rows are looked at.
    """
    shares = [_share(begin, end, pairs[row]) for row in range(len(pairs))]
    arrivals = [row for row in range(passed, len(pairs)) if shares[row] == 1]
    rows = range(passed, arrivals[0] + 1) if arrivals else range(len(pairs))
    taken: dict[float, int] = {}
    for row in rows:
        share = shares[row]
        if share and not any(abs(share - other) < SAME_STRETCH for other in taken):
            taken[share] = row
    return sorted(taken.items())


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


def _length(begin: Stretch, end: Stretch) -> float:
    return max(abs(b - a) for a, b in zip(begin, end, strict=True))


def _between(begin: Stretch, end: Stretch, share: float) -> Stretch:
    x, y = (a + share * (b - a) for a, b in zip(begin, end, strict=True))
    return x, y


def _share(begin: Stretch, end: Stretch, pair: NDArray[np.float64]) -> float | None:
    """Return where on the way a pair lies, in (0, 1], or None."""
    length = _length(begin, end)
    if length < SAME_STRETCH:
        return 1.0 if np.abs(pair - end).max() < SAME_STRETCH else None
    axis = int(np.argmax(np.abs(np.subtract(end, begin))))
    share = float((pair[axis] - begin[axis]) / (end[axis] - begin[axis]))
    if np.abs(pair - _between(begin, end, share)).max() > SAME_STRETCH:
        return None
    if abs(share - 1) * length < SAME_STRETCH:
        return 1.0
    return share if SAME_STRETCH < share * length < length else None
