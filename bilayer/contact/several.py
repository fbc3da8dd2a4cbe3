"""Several barriers of one skin: against itself, and against obstacles."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

Array = NDArray[np.float64]


class SkinBarrierState(Protocol):
    """A barrier in one state of the skin."""

    @property
    def points(self) -> Array:
        """The points of the skin, m, (k, 3)."""

    @property
    def pairs(self) -> int:
        """Number of pairs of places, or of points, within range."""

    @property
    def smallest_gap(self) -> float:
        """Smallest distance within range, m; infinity if there is none."""

    @property
    def force(self) -> float:
        """Sum of the forces with which places press, N."""

    @property
    def energy(self) -> float:
        """J."""

    @property
    def gradient(self) -> Array:
        """Derivative of the energy by the points, N, (k, 3)."""

    def hessian(self) -> csr_matrix:
        """Return the second derivative, N/m, (3 k, 3 k)."""

    def convex_hessian(self) -> csr_matrix:
        """Return the like of it without negative eigenvalues."""


class SkinBarrier(Protocol):
    """A barrier that acts on the points of a skin."""

    @property
    def range(self) -> float:
        """Distance from which on nothing acts, m."""

    def at(self, points: Array) -> SkinBarrierState:
        """Return the barrier with the skin's points at (k, 3), m."""

    def is_crossed(self, points: Array) -> bool:
        """Whether the skin passes through what the barrier keeps it off."""

    def free_share(self, start: Array, end: Array) -> float:
        """Return the share of straight ways from start to end until something touches."""

    def stays_clear(self, start: Array, end: Array) -> bool:
        """Whether nothing comes within range on straight ways from start to end."""


class SeveralBarriers:
    """Barriers that act together.

    Parameters
    ----------
    parts : sequence of SkinBarrier
        Of one skin.
    """

    def __init__(self, parts: Sequence[SkinBarrier]) -> None:
        self._parts = parts

    @property
    def range(self) -> float:
        """See `SkinBarrier`: the smallest one."""
        return min(part.range for part in self._parts)

    def at(self, points: Array) -> "SeveralStates":
        """See `SkinBarrier`."""
        return SeveralStates([part.at(points) for part in self._parts], points)

    def is_crossed(self, points: Array) -> bool:
        """See `SkinBarrier`."""
        return any(part.is_crossed(points) for part in self._parts)

    def free_share(self, start: Array, end: Array) -> float:
        """See `SkinBarrier`."""
        return min(part.free_share(start, end) for part in self._parts)

    def stays_clear(self, start: Array, end: Array) -> bool:
        """See `SkinBarrier`."""
        return all(part.stays_clear(start, end) for part in self._parts)


class SeveralStates:
    """Barriers in one state of the skin.

    Parameters
    ----------
    parts : sequence of SkinBarrierState
        Of each of them.
    points : (k, 3) array of float
        The points of the skin, m.
    """

    def __init__(self, parts: Sequence[SkinBarrierState], points: Array) -> None:
        self.parts, self.points = parts, points

    @property
    def pairs(self) -> int:
        """See `SkinBarrierState`."""
        return sum(part.pairs for part in self.parts)

    @property
    def smallest_gap(self) -> float:
        """See `SkinBarrierState`."""
        return min(part.smallest_gap for part in self.parts)

    @property
    def force(self) -> float:
        """See `SkinBarrierState`."""
        return sum(part.force for part in self.parts)

    @property
    def energy(self) -> float:
        """See `SkinBarrierState`."""
        return sum(part.energy for part in self.parts)

    @property
    def gradient(self) -> Array:
        """See `SkinBarrierState`."""
        return np.sum([part.gradient for part in self.parts], axis=0)

    def hessian(self) -> csr_matrix:
        """See `SkinBarrierState`."""
        return self._sum([part.hessian() for part in self.parts if part.pairs])

    def convex_hessian(self) -> csr_matrix:
        """See `SkinBarrierState`."""
        return self._sum([part.convex_hessian() for part in self.parts if part.pairs])

    def _sum(self, matrices: Sequence[csr_matrix]) -> csr_matrix:
        return sum(matrices, start=csr_matrix((self.points.size, self.points.size))).tocsr()
