"""Rigid obstacles: a barrier that keeps the points of a skin off a plane or a sphere, no friction.

A point at the distance d < d^ from the obstacle has the energy

    area . stiffness . d^ . b(d / d^),      b(s) = -(s - 1)^2 ln s,

the area being its share of the flat skin. It presses with area . stiffness . -b'(d / d^). The
obstacle is smooth and its gradient is a unit normal n, so with the distance's second derivative K

    gradient = e' n,      Hessian = e'' n n' + e' K.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.sparse import bsr_matrix, csr_matrix

Array = NDArray[np.float64]


class Obstacle(Protocol):
    """A rigid body with a smooth surface."""

    def distance(self, points: Array) -> Array:
        """Return how far points, (k, 3), are from its surface, m; negative inside."""

    def normals(self, points: Array) -> Array:
        """Return the gradient of the distance, (k, 3)."""

    def curvature(self, points: Array) -> Array:
        """Return the second derivative of the distance, 1/m, (k, 3, 3)."""

    def least_distance(self, start: Array, end: Array) -> Array:
        """Return the least distance of points on straight ways, m, (k,)."""

    def free_share(self, start: Array, end: Array) -> float:
        """Return the share of straight ways until the first point reaches its surface."""


@dataclass(frozen=True)
class Plane:
    """A half space below a plane.

    Parameters
    ----------
    point : (float, float, float)
        On the plane, m.
    normal : (float, float, float)
        Out of the half space, of length 1.
    """

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def distance(self, points: Array) -> Array:
        """See `Obstacle`."""
        return np.asarray((points - np.array(self.point)) @ np.array(self.normal))

    def normals(self, points: Array) -> Array:
        """See `Obstacle`."""
        return np.broadcast_to(np.array(self.normal), points.shape)

    def curvature(self, points: Array) -> Array:
        """See `Obstacle`."""
        return np.zeros((len(points), 3, 3))

    def least_distance(self, start: Array, end: Array) -> Array:
        """See `Obstacle`."""
        return np.minimum(self.distance(start), self.distance(end))

    def free_share(self, start: Array, end: Array) -> float:
        """See `Obstacle`."""
        before, after = self.distance(start), self.distance(end)
        through = after <= 0
        return float((before[through] / (before - after)[through]).min(initial=1.0))


@dataclass(frozen=True)
class Sphere:
    """A ball.

    Parameters
    ----------
    centre : (float, float, float)
        m.
    radius : float
        m.
    """

    centre: tuple[float, float, float]
    radius: float

    def distance(self, points: Array) -> Array:
        """See `Obstacle`."""
        return np.asarray(np.linalg.norm(points - np.array(self.centre), axis=1) - self.radius)

    def normals(self, points: Array) -> Array:
        """See `Obstacle`."""
        away = points - np.array(self.centre)
        return np.asarray(away / np.linalg.norm(away, axis=1)[:, None])

    def curvature(self, points: Array) -> Array:
        """See `Obstacle`."""
        normals = self.normals(points)
        far = self.distance(points) + self.radius
        across = np.eye(3) - normals[:, :, None] * normals[:, None]
        return np.asarray(across / far[:, None, None])

    def least_distance(self, start: Array, end: Array) -> Array:
        """See `Obstacle`."""
        away, way = start - np.array(self.centre), end - start
        square = (way**2).sum(axis=1)
        nearest = -(away * way).sum(axis=1)
        share = np.divide(nearest, square, out=np.zeros_like(square), where=square > 0)
        return self.distance(start + np.clip(share, 0, 1)[:, None] * way)

    def free_share(self, start: Array, end: Array) -> float:
        """See `Obstacle`: the smaller root of |start + t way - centre|^2 = radius^2."""
        through = self.least_distance(start, end) <= 0
        away, way = (start - np.array(self.centre))[through], (end - start)[through]
        a, b = (way**2).sum(axis=1), (away * way).sum(axis=1)
        c = (away**2).sum(axis=1) - self.radius**2
        root = (-b - np.sqrt(np.maximum(b**2 - a * c, 0.0))) / a
        return float(root.min(initial=1.0))


class ObstacleBarrier:
    """The barrier between a skin and obstacles; the like of `bilayer.contact.barrier.Barrier`.

    Parameters
    ----------
    obstacles : sequence of Obstacle
        What the skin stays off.
    areas : (k,) array of float
        Share of each point in the area of the flat skin, m2.
    range : float
        d^, m.
    stiffness : float
        A pressure, Pa.
    """

    def __init__(
        self, obstacles: Sequence[Obstacle], areas: Array, *, range: float, stiffness: float
    ) -> None:
        self.obstacles, self.areas = obstacles, areas
        self.range, self.stiffness = range, stiffness

    def at(self, points: Array) -> "ObstacleState":
        """Return the barrier with the skin's points at (k, 3), m."""
        return ObstacleState(self, points)

    def is_crossed(self, points: Array) -> bool:
        """Whether a point is inside an obstacle."""
        return any(bool((body.distance(points) <= 0).any()) for body in self.obstacles)

    def free_share(self, start: Array, end: Array) -> float:
        """Return the share of straight ways from start to end until a point touches."""
        return min((body.free_share(start, end) for body in self.obstacles), default=1.0)

    def stays_clear(self, start: Array, end: Array) -> bool:
        """Whether no point comes within range on straight ways from start to end."""
        return all(
            bool((body.least_distance(start, end) > self.range).all()) for body in self.obstacles
        )


def resting_share(pressure: float) -> float:
    """Return the distance at which a barrier bears a pressure over its stiffness, over the range.

    Examples
    --------
    >>> share = resting_share(0.01)
    >>> round(-2 * (1 - share) * np.log(share) + (1 - share) ** 2 / share, 12)
    0.01
    """
    return float(brentq(lambda s: (1 - s) ** 2 / s - 2 * (1 - s) * np.log(s) - pressure, 1e-9, 1))


class ObstacleState:
    """The barrier to obstacles in one state of the skin.

    Parameters
    ----------
    barrier : ObstacleBarrier
        Obstacles, areas, range and stiffness.
    points : (k, 3) array of float
        The points of the skin, m.
    """

    def __init__(self, barrier: ObstacleBarrier, points: Array) -> None:
        self._barrier, self.points = barrier, points
        self._near = [_NearPoints(barrier, body, points) for body in barrier.obstacles]

    @property
    def pairs(self) -> int:
        """Number of points within range, for each obstacle anew."""
        return sum(len(near.places) for near in self._near)

    @property
    def smallest_gap(self) -> float:
        """Smallest distance within range, m; infinity if there is none."""
        least = min(float(near.shares.min(initial=np.inf)) for near in self._near)
        return least * self._barrier.range

    @property
    def force(self) -> float:
        """Sum of the forces with which points press on obstacles, N."""
        return float(np.linalg.norm(self.gradient, axis=1).sum())

    @property
    def energy(self) -> float:
        """J; infinity if a point is inside an obstacle."""
        return sum(near.energy() for near in self._near)

    @cached_property
    def gradient(self) -> Array:
        """Derivative of the energy by the points, N, (k, 3)."""
        total = np.zeros_like(self.points)
        for near in self._near:
            total[near.places] += near.forces()
        return total

    def hessian(self) -> csr_matrix:
        """Return the second derivative, N/m, (3 k, 3 k)."""
        return self._matrix([near.stiffness() for near in self._near])

    def convex_hessian(self) -> csr_matrix:
        """Return the same without the part that the obstacle's curvature makes."""
        return self._matrix([near.convex_stiffness() for near in self._near])

    def _matrix(self, parts: Sequence[Array]) -> csr_matrix:
        """Return the block-diagonal matrix of 3 x 3 blocks at the points within range."""
        count = len(self.points)
        blocks = np.zeros((count, 3, 3))
        for near, part in zip(self._near, parts, strict=True):
            blocks[near.places] += part
        places = np.flatnonzero(blocks.any(axis=(1, 2)))
        starts = np.searchsorted(places, np.arange(count + 1))
        matrix = bsr_matrix((blocks[places], places, starts), shape=(3 * count, 3 * count))
        return matrix.tocsr()


class _NearPoints:
    """The points within range of one obstacle, and the barrier's derivatives there."""

    def __init__(self, barrier: ObstacleBarrier, body: Obstacle, points: Array) -> None:
        shares = body.distance(points) / barrier.range
        self.places = np.flatnonzero(shares < 1)
        self.shares = shares[self.places]
        self._body, self._points, self._range = body, points[self.places], barrier.range
        self._scale = barrier.stiffness * barrier.areas[self.places]

    def energy(self) -> float:
        if (self.shares <= 0).any():
            return float(np.inf)
        return float(self._range * self._scale @ (-((self.shares - 1) ** 2) * np.log(self.shares)))

    def forces(self) -> Array:
        return self._slope()[:, None] * self._body.normals(self._points)

    def convex_stiffness(self) -> Array:
        s = self.shares
        with np.errstate(all="ignore"):  # inside an obstacle it has no value, and is refused
            bend = -2 * np.log(s) - 4 * (s - 1) / s + ((s - 1) / s) ** 2
        normals = self._body.normals(self._points)
        along = normals[:, :, None] * normals[:, None]
        return np.asarray((self._scale * bend / self._range)[:, None, None] * along)

    def stiffness(self) -> Array:
        curved = self._slope()[:, None, None] * self._body.curvature(self._points)
        return self.convex_stiffness() + np.asarray(curved)

    def _slope(self) -> Array:
        """Return e', N: -(area) times the pressure."""
        s = self.shares
        with np.errstate(all="ignore"):
            slope = -2 * (s - 1) * np.log(s) - (s - 1) ** 2 / s
        return np.asarray(self._scale * slope)
