"""The held nodes of a body: one is held in x, y and z, one in y and z, one in z.

This removes the rigid motion and nothing else. Without weight the loads are in balance, the held
nodes carry nothing, and any three nodes will do that are not on a line. With weight the held nodes
carry the body, and their place matters. A body with weight is held at its centre, by the three
nodes nearest to it, as if clamped there. No part far from the centre is then lifted, and the
tangent plane of the centre stays level, to the accuracy of the mesh. A sheet with a hole in its
middle is held at the edge of the hole.

Where supports hold a part of the sheet, only what is left of the rigid motion is removed so.
"""

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]
Place = tuple[float, float] | Array

HeldNodes = tuple[int, int, int]
"""The one held in x, y and z, the one along x from it held in y and z, and the one held in z."""

RANK = 1e-6
"""Of coordinates in extents of the sheet: what moves less by a rigid motion does not remove it."""
LEAST_SINE = 0.3
"""Of the angle between the arms to the two other nodes, and of the first arm with the y axis."""
ORIGIN: Place = (0.0, 0.0)


def pins_besides(points: Array, held: Numbers, clamped: Numbers, nodes: HeldNodes) -> Numbers:
    """Return which of the six coordinates of held nodes are held besides the supports.

    Parameters
    ----------
    points : (n, 2) array of float
        Nodes of the flat state, m.
    held : (k, 2) array of int
        Node and axis of each coordinate that supports hold.
    clamped : (c, 2) array of int
        Ends of the edges about which the sheet cannot turn.
    nodes : (int, int, int)
        The three nodes.

    Returns
    -------
    (m, 2) array of int
        Node and axis: each takes away a rigid motion that all before it leave.
    """
    a, b, c = nodes
    pins = np.array([(a, 0), (a, 1), (a, 2), (b, 1), (b, 2), (c, 2)])
    places = (points - points.mean(axis=0)) / np.ptp(points)
    rows = [*_rigid_rows(places, held), *_turning_rows(places, clamped)]
    needed = []
    for pin, row in zip(pins, _rigid_rows(places, pins), strict=True):
        if np.linalg.matrix_rank([*rows, row], tol=RANK) > _rank(rows):
            needed.append(pin)
            rows.append(row)
    return np.array(needed, dtype=np.int64).reshape(-1, 2)


def _rank(rows: list[Array]) -> int:
    return int(np.linalg.matrix_rank(rows, tol=RANK)) if rows else 0


def _rigid_rows(places: Array, held: Numbers) -> Array:
    """Return how each coordinate changes with the six rigid motions of the flat sheet, (k, 6)."""
    x, y = places[held[:, 0]].T
    none, one = np.zeros_like(x), np.ones_like(x)
    by_axis = np.array(
        [
            [one, none, none, none, none, -y],
            [none, one, none, none, none, x],
            [none, none, one, y, -x, none],
        ]
    )
    return np.asarray(by_axis[held[:, 1], :, np.arange(len(held))])


def _turning_rows(places: Array, edges: Numbers) -> Array:
    """Return how far the sheet turns about edges with the six rigid motions, (c, 6)."""
    along = places[edges[:, 1]] - places[edges[:, 0]]
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    none = np.zeros((len(edges), 1))
    return np.hstack([none, none, none, along, none])


def choose_held_nodes(points: Array, gravity: float, centre: Place = ORIGIN) -> HeldNodes:
    """Return the held nodes of a body, with or without weight; see the module.

    Parameters
    ----------
    points : (n, 2) array of float
        Nodes of the flat state, m.
    gravity : float
        Acceleration of the weight, m/s2.
    centre : (float, float)
        Centroid of the sheet, m.
    """
    choose = choose_nodes_at_centre if gravity else choose_nodes_inside
    return choose(points, centre)


def choose_nodes_inside(points: Array, centre: Place = ORIGIN) -> HeldNodes:
    """Choose the node nearest to the centre and those a third of the radius away along x and y.

    Nearer than the rim, they keep a dome upright: the frame hardly turns while it rises.
    """
    arms = _arms(points, centre)
    return _choose_nodes_along_axes(arms, np.linalg.norm(arms, axis=1).max() / 3)


def choose_nodes_at_centre(points: Array, centre: Place = ORIGIN) -> HeldNodes:
    """Choose the node nearest to the centre and its neighbours along x and y."""
    arms = _arms(points, centre)
    return _choose_nodes_along_axes(arms, np.partition(np.linalg.norm(arms, axis=1), 1)[1])


def _arms(points: Array, centre: Place) -> Array:
    """Return the ways to all nodes from the one nearest to the centre, m."""
    return points - points[np.argmin(np.linalg.norm(points - centre, axis=1))]


def _choose_nodes_along_axes(arms: Array, distance: float) -> HeldNodes:
    """Return the node of no arm and those whose arms are about `distance` long along x and y."""
    first = int(np.argmin(np.linalg.norm(arms, axis=1)))
    along = _nearest(arms, (distance, 0.0), (0.0, 1.0))
    across = _nearest(arms, (0.0, distance), arms[along])
    return first, along, across


def _nearest(arms: Array, target: Place, aside: Place) -> int:
    """Return the node whose arm ends nearest to a target, of those not nearly along a direction.

    If all are, as on a thin strip, return the one that reaches farthest from the direction.
    """
    x, y = np.divide(aside, np.linalg.norm(aside))
    sideways = np.abs(arms[:, 0] * y - arms[:, 1] * x)
    length = np.linalg.norm(arms, axis=1)
    spans = (sideways >= LEAST_SINE * length) & (length > 0)
    if not spans.any():
        if sideways.max() <= 1e-9 * length.max():
            raise InputError("points: all lie on a line, expected a sheet")
        return int(np.argmax(sideways))
    distance = np.linalg.norm(arms - target, axis=1)
    return int(np.argmin(np.where(spans, distance, np.inf)))
