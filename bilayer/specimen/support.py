"""Where a body is held: at three nodes, in x, y and z, in y and z, and in z.

That takes the rigid motion away and nothing else. Loads in balance leave nothing to carry, so any
three nodes do that span an angle. A weight is carried there, and it matters where: a weighted body
is held at its centre, as if clamped there, by the three nodes nearest to it, so that no part far
from the centre is lifted, and the tangent plane of the centre stays level as far as the mesh tells.
"""

import numpy as np
from numpy.typing import NDArray

HeldNodes = tuple[int, int, int]
"""The one held in x, y and z, the one along x from it held in y and z, and the one held in z."""


def support(points: NDArray[np.float64], gravity: float) -> HeldNodes:
    """Choose where a body is held, by whether it has a weight; see the module.

    Parameters
    ----------
    points : (n, 2) array of float
        Nodes of the flat state, m.
    gravity : float
        Acceleration of the weight, m/s2.
    """
    return clamped_at_centre(points) if gravity else held_upright(points)


def held_upright(points: NDArray[np.float64]) -> HeldNodes:
    """Choose the node nearest to the origin and those a third of the radius away along x and y.

    Nearer than the rim, they keep a dome upright: the frame hardly turns while it rises.
    """
    arms = _arms(points)
    return _held_at(arms, np.linalg.norm(arms, axis=1).max() / 3)


def clamped_at_centre(points: NDArray[np.float64]) -> HeldNodes:
    """Choose the node nearest to the origin and its neighbours along x and y."""
    arms = _arms(points)
    return _held_at(arms, np.partition(np.linalg.norm(arms, axis=1), 1)[1])


def _arms(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the ways to all nodes from the one nearest to the origin, m."""
    return points - points[np.argmin(np.linalg.norm(points, axis=1))]


def _held_at(arms: NDArray[np.float64], reach: float) -> HeldNodes:
    taken: list[int] = []
    for target in ((0.0, 0.0), (reach, 0.0), (0.0, reach)):
        distance = np.linalg.norm(arms - target, axis=1)
        distance[taken] = np.inf
        taken.append(int(np.argmin(distance)))
    return taken[0], taken[1], taken[2]
