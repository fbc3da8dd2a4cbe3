"""The shapes of another result, as the initial guesses of a run."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
from bilayer.results.milestones import along_milestones
from bilayer.results.schema import SAME_STRETCH, result_mesh
from bilayer.results.table import stretches
from bilayer.specimen.prestretch import StretchPair

Array = NDArray[np.float64]

SAME_PLACE = 9
"""Decimals of a share of a way that tell two shapes apart."""


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

    A result may have been at one prestretch more than once. Then the shape is taken that it came to
    next after the last one that was taken.

    Parameters
    ----------
    stretches : (k, 2) array of float
        (lambda_x, lambda_y) of each.
    positions : (k, n, 3) array of float
        The reference surface, m.
    last : int
        The last one that was taken; -1: none yet.
    """

    def __init__(self, stretches: Array, positions: Array, last: int = -1) -> None:
        self.stretches, self.positions, self.last = stretches, positions, last

    @classmethod
    def of(cls, start: xr.Dataset, mesh: PlanarMesh) -> "StartShapes":
        """Return the shapes of a result.

        Raises
        ------
        InputError
            It is on another planar mesh, or reached no milestone.
        """
        start = along_milestones(start)
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
        shares = [share_of_way(begin, end, pair) for pair in self.stretches]
        taken: dict[float, int] = {}
        for k in self._rows_up_to_arrival(shares):
            share = shares[k]
            if share is not None:
                taken.setdefault(round(share, SAME_PLACE), k)
        self.last = max([self.last, *taken.values()])
        length = way_length(begin, end)
        return [
            ShapeOnTheWay((1 - share) * length, self.positions[k])
            for share, k in sorted(taken.items())
        ]

    def _rows_up_to_arrival(self, shares: list[float | None]) -> range:
        """Return the shapes after the last one up to the first at the end; all if there is none."""
        later = range(self.last + 1, len(shares))
        arrival = next((k for k in later if shares[k] == 1), None)
        return range(len(shares)) if arrival is None else range(self.last + 1, arrival + 1)

    def take_nearest(self, target: StretchPair) -> ShapeOnTheWay:
        """Return the shape of the nearest prestretch, to stand in for that at a target.

        Nearest in the larger stretch, then in both; the first of those that are as near.
        """
        larger = np.abs(self.stretches.max(axis=1) - max(target))
        both = np.abs(self.stretches - target).max(axis=1)
        nearest = int(np.lexsort((both, larger))[0])
        self.last = max(self.last, nearest)
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
