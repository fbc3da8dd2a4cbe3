"""The rigid motion that lays a scan onto a surface: many starts, then iterated closest points.

The scan is turned, not the surface. Outliers do not count: points that are farther from the surface
than a few times the usual distance. Source of the steps: Chen and Medioni, *Object modelling by
registration of multiple range images*, Image and Vision Computing 10 (1992) 145-155 (distances from
tangent planes); Chetverikov et al., *Robust Euclidean alignment of 3D point sets: the trimmed
iterative closest point algorithm*, ibid. 23 (2005) 299-309.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.scan.samples import Samples, at_most

Array = NDArray[np.float64]

TURNS = 24
"""Starts about the axis of the thinnest extent."""
COARSE, MEDIUM, FINE = 200, 800, 6000
"""Points of the scan in the three stages."""
THIN = 2000
"""Samples of the surface in the first stage: the nearest of fewer are found sooner."""
KEPT = 0.85
"""Share of the points, the nearest ones, that steer the first stages."""
FAR = 3.0
"""Points farther away than so many standard deviations are outliers."""
NORMAL = 1.4826
"""Standard deviation over the median of the absolute values, of a normal distribution."""
SLIDING = 0.01
"""Weight of distances along the tangent planes, of those from the planes it is 1."""
LONGEST = 25
STILL = 1e-5
"""A step that turns by less, and shifts by less of the size of the surface, is the last."""


@dataclass(frozen=True)
class Motion:
    """x -> R x + t.

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)
        R.
    shift : ndarray, shape (3,)
        t, m.
    """

    rotation: Array
    shift: Array

    def moved(self, points: Array) -> Array:
        """Return points after the motion, shape (n, 3)."""
        return np.asarray(points @ self.rotation.T + self.shift)

    def then(self, other: "Motion") -> "Motion":
        """Return this motion and another one after it."""
        return Motion(other.rotation @ self.rotation, other.rotation @ self.shift + other.shift)


def placed(scan: Array, surface: Samples) -> Motion:
    """Return the motion that lays a scan onto a surface.

    Parameters
    ----------
    scan : ndarray, shape (n, 3)
        Points in any position, m.
    surface : Samples
        What they are laid onto.
    """
    few, some, many = (at_most(count, scan) for count in (COARSE, MEDIUM, FINE))
    thin = surface.thinned(THIN)
    likely = _lowest(starts(scan, surface), few, thin, count=24)
    rough = [_refined(start, few, thin, steps=4) for start in likely]
    best = _lowest(rough, few, thin, count=4)
    better = [_refined(motion, some, surface, steps=LONGEST) for motion in best]
    (start,) = _lowest(better, some, surface, count=1)
    last = _refined(start, many, surface, steps=LONGEST, robust=True)
    return _lowest([last, start], many, surface, count=1)[0]  # it may get lost on another shape


def refined(motion: Motion, scan: Array, surface: Samples) -> Motion:
    """Return the motion that lays a scan onto a surface, from one that nearly does so."""
    many = at_most(FINE, scan)
    return _refined(motion, many, surface, steps=LONGEST, robust=True)


def starts(scan: Array, surface: Samples) -> list[Motion]:
    """Return the motions to start from.

    They bring the centroids together, each of the three principal axes of the scan, either way up,
    onto the thinnest extent of the surface, and turn it about that.
    """
    home, frame = _frame(surface.points)
    centre, axes = _frame(scan)
    found = []
    for k in range(3):
        own = np.roll(axes, -k, axis=0)
        for sign in (1, -1):
            upright = np.array([own[0], sign * own[1], sign * own[2]])
            for turn in 2 * math.pi * np.arange(TURNS) / TURNS:
                rotation = frame.T @ _rotation(np.array([0.0, 0.0, turn])) @ upright
                found.append(Motion(rotation, home - rotation @ centre))
    return found


def outlier_limit(distances: Array) -> float:
    """Return the distance beyond which points are outliers, m."""
    return FAR * NORMAL * float(np.median(np.abs(distances)))


def _refined(
    motion: Motion, scan: Array, surface: Samples, steps: int, robust: bool = False
) -> Motion:
    """Return a motion after some steps towards the tangent planes of the nearest samples."""
    for _ in range(steps):
        points = motion.moved(scan)
        found = surface.nearest(points)
        size = np.abs(found.distance)
        limit = outlier_limit(found.distance) if robust else np.quantile(size, KEPT)
        near = size <= limit
        if robust:
            near &= ~found.is_beyond
        if near.sum() < 6:
            return motion
        sample = found.sample[near]
        offset = points[near] - surface.points[sample]
        step = _step(points[near], offset, surface.normals[sample])
        motion = motion.then(step)
        turn = np.linalg.norm(step.rotation - np.eye(3))
        if turn < STILL and np.linalg.norm(step.shift) < STILL * surface.size:
            break
    return motion


def _step(points: Array, offset: Array, normals: Array) -> Motion:
    """Return the small motion with the least squares of the distances from tangent planes.

    Distances along the planes count a little, so that nothing slides off a surface that is nearly
    flat, and a sheet as round as a sphere does not turn.

    Parameters
    ----------
    points, offset, normals : ndarray, shape (n, 3)
        Points, where they are from their samples, m, and the samples' normals.
    """
    centre = points.mean(axis=0)
    size = float(np.linalg.norm(points - centre, axis=1).max()) or 1.0
    x, y, z = ((points - centre) / size).T
    none, ones = np.zeros_like(x), np.ones_like(x)
    moves = np.array(  # of a point by turns about x, y, z and by shifts
        [
            [none, z, -y, ones, none, none],
            [-z, none, x, none, ones, none],
            [y, -x, none, none, none, ones],
        ]
    ).transpose(2, 0, 1)
    along = np.einsum("nk,nki->ni", normals, moves)
    matrix = (1 - SLIDING) * along.T @ along + SLIDING * np.einsum("nki,nkj->ij", moves, moves)
    force = (1 - SLIDING) * along.T @ np.sum(normals * offset, axis=1)
    force += SLIDING * np.einsum("nki,nk->i", moves, offset)
    solution = np.linalg.solve(matrix, -force)
    rotation = _rotation(solution[:3] / size)
    return Motion(rotation, centre - rotation @ centre + solution[3:])


def _rotation(turn: Array) -> Array:
    """Return the rotation by a vector, shape (3, 3)."""
    from scipy.spatial.transform import Rotation  # slow to load

    return np.asarray(Rotation.from_rotvec(turn).as_matrix())


def _lowest(motions: Sequence[Motion], scan: Array, surface: Samples, count: int) -> list[Motion]:
    """Return the motions after which the nearest points are nearest."""
    costs = []
    for motion in motions:
        moved = motion.moved(scan)
        near = np.sort(surface.tree.query(moved)[0])[: int(KEPT * len(scan))]
        costs.append(float(np.mean(near**2)))
    return [motions[k] for k in np.argsort(costs, kind="stable")[:count]]


def _frame(points: Array) -> tuple[Array, Array]:
    """Return the centroid and the principal axes, a right-handed system, the thinnest last."""
    centre = points.mean(axis=0)
    _, axes = np.linalg.eigh(np.cov((points - centre).T))
    frame = axes.T[::-1].copy()
    if np.linalg.det(frame) < 0:
        frame[0] *= -1
    return centre, frame
