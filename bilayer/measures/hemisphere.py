"""Distance of a shape from the hemisphere of equal meridian.

A disc of radius R has meridians of length R. So does the hemisphere of radius a = 2 R / pi. Any
other sheet is compared with the hemisphere of the disc of its area. The distance between a surface
S and that hemisphere H is the area-weighted symmetric root mean square

    sqrt( (mean over S of d(x, H)^2 + mean over H of d(x, S)^2) / 2 )

with d to the nearest point, minimised over the position of H. Both directions count, so that
neither a surface that covers only a part of H, nor one that reaches beyond it, has the distance 0.
The result is divided by the distance of the flat disc: 0 is the hemisphere and 1 is flat.
"""

import math
from functools import lru_cache

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.geometry.nearest_point import NearestPoint
from bilayer.geometry.surface import Surface
from bilayer.measures.body_frame import BodyFrame

Array = NDArray[np.float64]

SAMPLES = 2000
"""Points that stand for the hemisphere; twice as many change the distance by less than 0.1 %."""


def hemisphere_distance(surface: Surface, frame: BodyFrame, flat_radius: float) -> float:
    """Return the distance of a surface from the hemisphere of equal meridian, over the flat disc's.

    Parameters
    ----------
    surface : Surface
        The released shape.
    frame : BodyFrame
        Its own frame, whose z axis is where the search for the best placing starts.
    flat_radius : float
        Radius R of the flat disc, m; for any other outline that of the circle of its area.
    """
    radius = 2 * flat_radius / math.pi
    scaled = np.divide(frame.coordinates(surface.points), radius)
    aligned_surface = Surface(scaled, surface.triangles)
    return _distance_at_best(aligned_surface) * radius / flat_disc_distance(flat_radius)


def flat_disc_distance(flat_radius: float) -> float:
    """Return the same distance of a flat disc of radius R, m.

    With a = 2 R / pi and the disc at height z over the hemisphere's rim, mean over the disc of
    (sqrt(r^2 + z^2) - a)^2 = R^2/2 + z^2 - 4 a ((R^2 + z^2)^(3/2) - z^3) / (3 R^2) + a^2, and mean
    over the hemisphere, whose feet lie inside the disc, of (a cos t - z)^2 = a^2/3 - a z + z^2.
    """
    R, a = 1.0, 2 / math.pi

    def mean_square(z: float) -> float:
        from_disc = R**2 / 2 + z**2 - 4 * a * ((R**2 + z**2) ** 1.5 - z**3) / (3 * R**2) + a**2
        from_hemisphere = a**2 / 3 - a * z + z**2
        return (from_disc + from_hemisphere) / 2

    best = scipy.optimize.minimize_scalar(
        mean_square, bounds=(0.0, a), method="bounded", options={"xatol": 1e-9}
    )
    return flat_radius * math.sqrt(best.fun)


def vectors_from_unit_hemisphere(points: Array) -> Array:
    """Return the vector to points from the nearest one of the unit sphere's upper half, (n, 3).

    Above the plane of the rim it is radial; below, the nearest point is on the rim. From the
    centre it is the vector to the pole.
    """
    nearest = np.array(points)
    nearest[nearest[:, 2] < 0, 2] = 0
    length = np.linalg.norm(nearest, axis=1)
    nearest[length == 0] = 0, 0, 1
    return points - nearest / np.where(length > 0, length, 1)[:, None]


def unit_hemisphere_samples(count: int) -> Array:
    """Return points of equal area each on the upper half of the unit sphere, shape (count, 3).

    A Fibonacci lattice: equal steps in height, the golden angle around (Gonzalez 2010, Measurement
    of areas on a sphere using Fibonacci and latitude-longitude lattices, Math. Geosci. 42).
    """
    order = np.arange(count)
    z = (order + 0.5) / count
    around = order * math.pi * (3 - math.sqrt(5))
    across = np.sqrt(1 - z**2)
    return np.column_stack([across * np.cos(around), across * np.sin(around), z])


def _distance_at_best(surface: Surface) -> float:
    """Least symmetric distance between a surface and a unit hemisphere, which moves.

    The unknowns are the hemisphere's centre and its turns about the axis x and the turned axis y.
    """
    nearest = NearestPoint(surface)
    hemisphere = unit_hemisphere_samples(SAMPLES)
    share = np.sqrt(surface.sample_areas / surface.areas.sum() / 2)
    share_back = np.full(SAMPLES, 1 / math.sqrt(2 * SAMPLES))

    @lru_cache(maxsize=1)  # the residuals and their derivatives are asked for one after the other
    def residuals(*unknowns: float) -> tuple[Array, Array]:
        centre, (about_x, about_y) = np.array(unknowns[:3]), unknowns[3:]
        turn = scipy.spatial.transform.Rotation.from_euler("XY", [about_x, about_y])
        axes = np.array([[1.0, 0, 0], [0, math.cos(about_x), math.sin(about_x)]])
        from_centre, around = surface.samples - centre, turn.apply(hemisphere)
        there = turn.apply(vectors_from_unit_hemisphere(turn.inv().apply(from_centre)))
        back = nearest.vectors_to(centre + around)
        parts = [
            _distances_as_it_moves(share, there, -1.0, from_centre, axes),
            _distances_as_it_moves(share_back, back, 1.0, around, axes),
        ]
        values, derivatives = (np.concatenate(part) for part in zip(*parts, strict=True))
        return values, derivatives

    centroids_meet = surface.centroid - [0.0, 0.0, 0.5]
    best = scipy.optimize.least_squares(
        lambda unknowns: residuals(*unknowns)[0],
        [*centroids_meet, 0.0, 0.0],
        lambda unknowns: residuals(*unknowns)[1],
        method="lm",
        xtol=1e-5,
        ftol=1e-6,
    )
    return math.sqrt(2 * best.cost)


def _distances_as_it_moves(
    weights: Array, away: Array, sense: float, arms: Array, axes: Array
) -> tuple[Array, Array]:
    """Return weighted distances, (n,), and their derivatives by a translation and turns, (n, 5).

    Parameters
    ----------
    weights : (n,) array of float
        Of the points.
    away : (n, 3) array of float
        Vectors to them from the nearest points of the other body.
    sense : float
        1 if the points move, -1 if the other body does.
    arms : (n, 3) array of float
        Vectors to the points from the centre of the turns.
    axes : (2, 3) array of float
        Of the turns.
    """
    distance = np.linalg.norm(away, axis=1)
    direction = away / np.where(distance > 0, distance, 1)[:, None]
    turns = np.cross(arms, direction) @ axes.T  # n . (axis x arm) = axis . (arm x n)
    derivatives = sense * np.column_stack([direction, turns])
    return weights * distance, weights[:, None] * derivatives
