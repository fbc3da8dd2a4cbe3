"""The two-sided distance of a shape from a target, its best placing, and its gradient.

    D^2 = (mean over S of d(x, T)^2 + mean over T of d(y, S)^2) / 2

with the shape S, the target T, area-weighted means, and d to the nearest point, minimised over the
place of T (and its size, if that is free). Both directions count: a shape that crumples onto a part
of T is as far from it as one that reaches beyond. At the best place the derivative by the place is
zero, so the gradient by the shape is that at a fixed place (envelope theorem).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.geometry.nearest_point import NearestPoint
from bilayer.geometry.surface import Surface

Array = NDArray[np.float64]

FALL, MOTION = 1e-11, 1e-8
"""Relative changes of the squared distance and of the place at which the search for it ends.

The distance errs by the square of the place, but its gradient by the place itself."""
MOST_TRIES = 30
FIRST_PLACES = 2
"""Places from which the best one is searched if none is known, the nearest of those tried."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a target lies: a point y of it at size * rotation y + shift.

    Parameters
    ----------
    rotation : (3, 3) array of float
        A proper rotation.
    shift : (3,) array of float
        m.
    size : float
        Factor of all lengths of the target.
    """

    rotation: Array
    shift: Array
    size: float = 1.0

    def bring(self, points: Array) -> Array:
        """Return points in space as the target that was not placed has them, (n, 3)."""
        return np.asarray((points - self.shift) @ self.rotation / self.size)

    def take(self, points: Array) -> Array:
        """Return points of the target in space, m, shape (n, 3)."""
        return self.size * points @ self.rotation.T + self.shift

    def moved(self, change: Array) -> "Place":
        """Return the place after turns about its own axes x, y, z, a shift along them, a growth."""
        turn = scipy.spatial.transform.Rotation.from_euler("XYZ", change[:3]).as_matrix()
        shift = self.shift + self.rotation @ change[3:6]
        size = self.size * np.exp(change[6]) if len(change) > 6 else self.size
        return Place(self.rotation @ turn, shift, float(size))


@dataclass(frozen=True, eq=False)
class Distance:
    """The distance of a shape from the target at its best place.

    Parameters
    ----------
    mean_square : float
        D^2, m2.
    gradient : (n, 3) array of float
        Its derivative by the nodes of the shape, m.
    place : Place
        Of the target.
    mean, largest : float
        Of the distances, both ways, m.
    """

    mean_square: float
    gradient: Array
    place: Place
    mean: float
    largest: float

    @property
    def rms(self) -> float:
        """D, m."""
        return float(np.sqrt(self.mean_square))


class TargetDistance:
    """Measures the distance from one target.

    Parameters
    ----------
    target : Surface
        In its own axes, m.
    is_size_free : bool
        Whether the target may grow and shrink.
    """

    def __init__(self, target: Surface, is_size_free: bool = False) -> None:
        self.target, self.is_size_free = target, is_size_free
        self._nearest = NearestPoint(target)
        self._samples = target.corners.mean(axis=1)
        self._shares = target.areas / target.areas.sum()

    @property
    def diagonal(self) -> float:
        """Diagonal of the target's bounding box, m."""
        return float(np.linalg.norm(np.ptp(self.target.points, axis=0)))

    def measure(self, shape: Surface, near: Place) -> Distance:
        """Return the distance of a shape, the best place being searched from one nearby."""
        meeting = _Meeting(self, shape)
        return meeting.distance(meeting.best(near))

    def measure_anew(self, shape: Surface) -> Distance:
        """Return the distance of a shape from the best of several first places."""
        meeting = _Meeting(self, shape)
        tried = sorted(
            (meeting.distance(place) for place in self._first_places(shape)),
            key=lambda each: each.mean_square,
        )
        found = [meeting.distance(meeting.best(each.place)) for each in tried[:FIRST_PLACES]]
        return min(found, key=lambda each: each.mean_square)

    def curvature(self, shape: Surface, place: Place, changes: Array) -> Array:
        """Return the second derivative of D^2 by variables of a shape, as Gauss and Newton have it.

        The distances are taken as linear functions of the variables and of the place, the best of
        which is chosen (Golub and Pereyra's variable projection, after Kaufman).

        Parameters
        ----------
        shape : Surface
            The shape.
        place : Place
            The best place.
        changes : (k, n, 3) array of float
            Derivatives of the shape by the variables.

        Returns
        -------
        (k, k) array of float
            Positive semidefinite.
        """
        return _Meeting(self, shape).curvature(place, changes)

    def _first_places(self, shape: Surface) -> list[Place]:
        """Return places where centroids and principal axes meet, turned in all proper ways."""
        own, axes = _axes_of(self.target)
        centre, others = _axes_of(shape)
        places = []
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            for order in ((0, 1, 2), (1, 0, 2)):
                turned = others[:, order] * [*signs, 1]
                turned[:, 2] *= np.sign(np.linalg.det(turned))
                rotation = turned @ axes.T
                places.append(Place(rotation, centre - rotation @ own))
        return places


class _Meeting:
    """A shape and the target, for the search of the best place."""

    def __init__(self, own: TargetDistance, shape: Surface) -> None:
        self._own, self._shape = own, shape
        self._nearest = NearestPoint(shape)
        self._shares = shape.sample_areas / shape.areas.sum()

    def best(self, near: Place) -> Place:
        """Return the best place near one."""

        @lru_cache(maxsize=1)  # residuals and derivatives are asked for one after the other
        def residuals(*change: float) -> tuple[Array, Array]:
            return self._residuals(near.moved(np.array(change)), np.array(change))

        found = scipy.optimize.least_squares(
            lambda change: residuals(*change)[0],
            np.zeros(7 if self._own.is_size_free else 6),
            lambda change: residuals(*change)[1],
            method="lm",
            xtol=MOTION,
            ftol=FALL,
            max_nfev=MOST_TRIES,
        )
        return near.moved(found.x)

    def _vectors(self, place: Place) -> tuple[Array, Array, NDArray[np.int64]]:
        """Return vectors from the target to the shape's samples and from the shape to the target's.

        In the target's axes, m, with the triangles of the shape that the second come from.
        """
        there, _ = self._own._nearest.feet_of(place.bring(self._shape.samples))
        at = place.take(self._own._samples)
        back, triangles = self._nearest.feet_of(at)
        return place.size * there, back @ place.rotation, triangles

    def _residuals(self, place: Place, change: Array) -> tuple[Array, Array]:
        """Return weighted distances and their derivatives by the change of the place.

        The axes of Euler's turns are those of the place before all turns.
        """
        there, back, _ = self._vectors(place)
        (x, y, _z), own = change[:3], scipy.spatial.transform.Rotation
        first = own.from_euler("XYZ", change[:3]).as_matrix()
        axes = np.array(
            [[1.0, 0.0, 0.0], own.from_euler("X", x).apply([0, 1, 0]),
             own.from_euler("XY", [x, y]).apply([0, 0, 1])]
        ) @ first  # in the turned axes of the place  # fmt: skip
        shape_samples = place.size * place.bring(self._shape.samples)
        samples = place.size * self._own._samples
        values, derivatives = [], []
        for away, arms, shares, sense in (
            (there, shape_samples, self._shares, -1.0),
            (back, samples, self._own._shares, 1.0),
        ):
            distance, direction = np.linalg.norm(away, axis=1), _unit(away)
            turns = np.cross(arms, direction) @ axes.T
            columns = [turns, direction @ first.T]
            if len(change) > 6:
                # the foot moves with its own place as the target grows about its origin
                feet = arms - away if sense < 0 else arms
                columns.append(np.sum(feet * direction, axis=1, keepdims=True))
            weight = np.sqrt(shares / 2)
            values.append(weight * distance)
            derivatives.append(sense * weight[:, None] * np.column_stack(columns))
        return np.concatenate(values), np.concatenate(derivatives)

    def curvature(self, place: Place, changes: Array) -> Array:
        """See `TargetDistance.curvature`."""
        there, back, triangles = self._vectors(place)
        corners = changes[:, self._shape.triangles]
        at_samples = (corners / 2 + corners.mean(axis=2, keepdims=True) / 2).reshape(
            len(changes), -1, 3
        )
        feet = place.take(self._own._samples) - back @ place.rotation.T
        shares = self._nearest.shares_of(feet, triangles)
        at_feet = np.einsum("qc,kqcx->kqx", shares, corners[:, triangles])
        columns = [
            np.sqrt(weights / 2) * np.einsum("qx,kqx->kq", sense * _unit(away), moves)
            for weights, away, moves, sense in (
                (self._shares, there @ place.rotation.T, at_samples, 1.0),
                (self._own._shares, back @ place.rotation.T, at_feet, -1.0),
            )
        ]
        by_variables = np.concatenate(columns, axis=1).T
        unmoved = np.zeros(7 if self._own.is_size_free else 6)
        _, by_place = self._residuals(place, unmoved)
        by_variables -= by_place @ np.linalg.lstsq(by_place, by_variables, rcond=1e-8)[0]
        return np.asarray(2 * by_variables.T @ by_variables)

    def distance(self, place: Place) -> Distance:
        """Return the distance at a place."""
        there, back, triangles = self._vectors(place)
        square, square_back = np.sum(there**2, axis=1), np.sum(back**2, axis=1)
        shares, shares_back = self._shares, self._own._shares
        mean = shares @ square
        gradient = self._gradient(there @ place.rotation.T, square - mean)
        gradient += self._gradient_back(place, back @ place.rotation.T, triangles)
        apart = np.sqrt(np.concatenate([square, square_back]))
        return Distance(
            float(mean + shares_back @ square_back) / 2,
            gradient,
            place,
            float(np.concatenate([shares, shares_back]) @ apart) / 2,
            float(apart.max()),
        )

    def _gradient(self, there: Array, excess: Array) -> Array:
        """Return the derivative of half of the mean over the shape, (n, 3).

        The samples move with their corners, and their shares change with the areas.
        """
        surface = self._shape
        pulls = (self._shares[:, None] * there).reshape(-1, 3, 3)
        by_corner = pulls / 2 + pulls.sum(axis=1, keepdims=True) / 6
        a, b, c = np.moveaxis(surface.corners, 1, 0)
        normals = surface.area_vectors / surface.areas[:, None]
        weight = excess.reshape(-1, 3).mean(axis=1) / surface.areas.sum() / 2
        for corner, side in enumerate((b - c, c - a, a - b)):
            by_corner[:, corner] += 0.5 * weight[:, None] * np.cross(side, normals)
        return _sum_at_nodes(surface, np.arange(len(by_corner)), by_corner)

    def _gradient_back(self, place: Place, back: Array, triangles: NDArray[np.int64]) -> Array:
        """Return the derivative of half of the mean over the target, (n, 3)."""
        feet = place.take(self._own._samples) - back
        shares = self._nearest.shares_of(feet, triangles)
        pulls = -self._own._shares[:, None] * back
        return _sum_at_nodes(self._shape, triangles, shares[:, :, None] * pulls[:, None])


def _unit(vectors: Array) -> Array:
    """Return vectors over their lengths; 0 where they are 0."""
    length = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(length > 0, length, 1.0)[:, None]


def _sum_at_nodes(surface: Surface, triangles: NDArray[np.int64], by_corner: Array) -> Array:
    total = np.zeros_like(surface.points)
    np.add.at(total, surface.triangles[triangles], by_corner)
    return total


def _axes_of(surface: Surface) -> tuple[Array, Array]:
    """Return the centroid and the axes of a surface, the last along its mean upward normal."""
    up = surface.area_vectors.sum(axis=0)
    up = up / np.linalg.norm(up)
    arms = surface.samples - surface.centroid
    flat = arms - np.outer(arms @ up, up)
    spread = flat.T @ (surface.sample_areas[:, None] * flat)
    _, vectors = np.linalg.eigh(spread)
    x = vectors[:, 2] - up * (vectors[:, 2] @ up)
    x /= np.linalg.norm(x)
    return surface.centroid, np.column_stack([x, np.cross(up, x), up])
