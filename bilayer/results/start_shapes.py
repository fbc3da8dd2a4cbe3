"""The shapes of another result, as the initial guesses of a run."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.schema import SAME_STRETCH, result_mesh
from bilayer.results.table import stretches
from bilayer.specimen.prestretch import StretchPair

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ShapeOnTheWay:
    """A shape between two targets.

    Parameters
    ----------
    remaining : float
        Change of the prestretch from the shape to the second target, 0 at it.
    shape : (n, 3) array of float
        The reference surface, m, in any position and orientation.
    """

    remaining: float
    shape: Array


class StartShapes:
    """The shapes that another result reached, in its order.

    A result that goes up and down passes a prestretch more than once. The shapes of a way are those
    from `passed`, the one at which it begins, to the first that is at its end. If there is none,
    all are looked at.

    Parameters
    ----------
    stretches : (k, 2) array of float
        (lambda_x, lambda_y) of each.
    positions : (k, n, 3) array of float
        The reference surface, m.
    passed : int
        The one at the last target.
    """

    def __init__(self, stretches: Array, positions: Array, passed: int = 0) -> None:
        self.stretches, self.positions, self.passed = stretches, positions, passed

    @classmethod
    def of(cls, start: xr.Dataset, mesh: PlanarMesh) -> "StartShapes":
        """Return the shapes of a result.

        Raises
        ------
        InputError
            It is on another planar mesh, or reached no milestone.
        """
        if not result_mesh(start).same_as(mesh):
            raise InputError(
                f"start: has {start.sizes['node']} nodes and {start.sizes['face']} triangles of "
                f"its own, expected a result on the planar mesh of this run ({len(mesh.points)} "
                "nodes)"
            )
        reached = start["converged"].values == 1
        if not reached.any():
            raise InputError("start: has no converged milestone, expected at least one")
        return cls(stretches(start)[reached], start["position"].values[reached])

    def take_shapes(self, begin: StretchPair, end: StretchPair) -> list[ShapeOnTheWay]:
        """Return the shapes on the way from one target to the next, in their order."""
        taken = self._places_on_way(begin, end)
        if taken and taken[-1][0] == 1:
            self.passed = taken[-1][1]
        length = way_length(begin, end)
        return [ShapeOnTheWay((1 - share) * length, self.positions[k]) for share, k in taken]

    def _places_on_way(self, begin: StretchPair, end: StretchPair) -> list[tuple[float, int]]:
        """Return the share of the way and the number of each shape on it, ascending."""
        count = len(self.stretches)
        shares = [share_of_way(begin, end, self.stretches[k]) for k in range(count)]
        arrivals = [k for k in range(self.passed, count) if shares[k] == 1]
        taken: dict[float, int] = {}
        for k in range(self.passed, arrivals[0] + 1) if arrivals else range(count):
            share = shares[k]
            if share and not any(abs(share - other) < SAME_STRETCH for other in taken):
                taken[share] = k
        return sorted(taken.items())

    def nearest(self, target: StretchPair) -> ShapeOnTheWay:
        """Return the shape of the nearest prestretch, to stand in for that at a target.

        Nearest in the larger stretch, then in both; the first of those that are as near.
        """
        larger = np.abs(self.stretches.max(axis=1) - max(target))
        both = np.abs(self.stretches - target).max(axis=1)
        nearest = int(np.lexsort((both, larger))[0])
        return ShapeOnTheWay(0.0, self.positions[nearest])


def way_length(begin: StretchPair, end: StretchPair) -> float:
    """Return the larger change of the two stretches."""
    return max(abs(b - a) for a, b in zip(begin, end, strict=True))


def share_of_way(begin: StretchPair, end: StretchPair, pair: Array) -> float | None:
    """Return the share of a way at which a pair of stretches lies, in (0, 1], or None."""
    length = way_length(begin, end)
    if length < SAME_STRETCH:
        return 1.0 if np.abs(pair - end).max() < SAME_STRETCH else None
    axis = int(np.argmax(np.abs(np.subtract(end, begin))))
    share = float((pair[axis] - begin[axis]) / (end[axis] - begin[axis]))
    between = np.add(begin, share * np.subtract(end, begin))
    if np.abs(pair - between).max() > SAME_STRETCH:
        return None
    if abs(share - 1) * length < SAME_STRETCH:
        return 1.0
    return share if SAME_STRETCH < share * length < length else None
