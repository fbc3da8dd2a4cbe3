"""Where a body is held: at three nodes, in x, y and z, in y and z, and in z.

That takes the rigid motion away and nothing else. Loads in balance leave nothing to carry, so any
three nodes do that span an angle. A weight is carried there, and it matters where: a weighted body
is held at its centre, as if clamped there, by the three nodes nearest to it, so that no part far
from the centre is lifted, and the tangent plane of the centre stays level as far as the mesh tells.
A sheet with a hole in its middle is held around that hole.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
HeldNodes = tuple[int, int, int]
"""The one held in x, y and z, the one along x from it held in y and z, and the one held in z."""

LEAST_LEVER = 0.25
"""Distance of the held nodes from each other, at least, over what is asked for."""


def support(points: Array, centre: Array, gravity: float) -> HeldNodes:
    """Choose where a body is held, by whether it has a weight; see the module.

    Parameters
    ----------
    points : (n, 2) array of float
        Nodes of the flat state, m.
    centre : (2,) array of float
        The centre of its area, m.
    gravity : float
        Acceleration of the weight, m/s2.
    """
    return clamped_at_centre(points, centre) if gravity else held_upright(points, centre)


def held_upright(points: Array, centre: Array) -> HeldNodes:
    """Choose the node nearest to the centre and those a third of the radius away along x and y.

    Nearer than the rim, they keep a dome upright: the frame hardly turns while it rises.
    """
    return _held_around(points, centre, np.linalg.norm(_arms(points, centre), axis=1).max() / 3)


def clamped_at_centre(points: Array, centre: Array) -> HeldNodes:
    """Choose the node nearest to the centre and its neighbours along x and y."""
    return _held_around(points, centre, _spacing(_arms(points, centre)))


def _arms(points: Array, centre: Array) -> Array:
    """Return the ways to all nodes from the one nearest to the centre, m."""
    return points - points[np.argmin(np.linalg.norm(points - centre, axis=1))]


def _spacing(arms: Array) -> float:
    """Return how far the nearest neighbour is, m."""
    return float(np.partition(np.linalg.norm(arms, axis=1), 1)[1])


def _held_around(points: Array, centre: Array, reach: float) -> HeldNodes:
    """Choose nodes that far apart from the centre, or around the hole that it lies in."""
    arms = _arms(points, centre)
    hole = float(np.linalg.norm(points - centre, axis=1).min())
    if hole > _spacing(arms):
        arms, reach = points - centre, max(reach, hole)
        return _held_at(arms, [(-reach, 0.0), (reach, 0.0), (0.0, reach)])
    return _held_at(arms, [(0.0, 0.0), (reach, 0.0), (0.0, reach)])


def _held_at(arms: Array, targets: list[tuple[float, float]]) -> HeldNodes:
    """Choose the nodes nearest to three places that can hold a body."""
    least = LEAST_LEVER * (targets[1][0] - targets[0][0])
    first = int(np.argmin(np.linalg.norm(arms - targets[0], axis=1)))
    arms, places = arms - arms[first], np.subtract(targets, arms[first])
    second = _nearest(arms, places[1], np.abs(arms[:, 0]), least)
    x, y = arms[second] / np.linalg.norm(arms[second])
    third = _nearest(arms, places[2], np.abs(x * arms[:, 1] - y * arms[:, 0]), least)
    return first, second, third


def _nearest(arms: Array, place: Array, lever: Array, least: float) -> int:
    """Return the node nearest to a place of those that have a lever of at least so much, m."""
    distance = np.linalg.norm(arms - place, axis=1)
    distance[lever < min(least, lever.max())] = np.inf
    return int(np.argmin(distance))
