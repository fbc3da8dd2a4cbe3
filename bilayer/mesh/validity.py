"""The checks that points and triangles are a mesh of one flat sheet.

Every point is in a triangle. Every triangle is counterclockwise and has an area. Every edge has one
triangle, or two on different sides. All triangles form one connected piece. The error names the
first point, triangle or edge that fails.
"""

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import directed_edges

Indices = NDArray[np.int64]

SLIVER = 1e-6
"""Height of a triangle over its longest edge, from which on it is degenerate."""


FARTHEST = 1e6
"""Largest coordinate of a node, m."""


def check_points(points: NDArray[np.float64]) -> None:
    """Raise InputError if a coordinate is none of a sheet; points of shape (n, 2) or (n, 3)."""
    bad = np.flatnonzero(~(np.abs(points) <= FARTHEST).all(axis=1))
    if len(bad):
        raise InputError(
            f"node {bad[0]} lies at {points[bad[0]]}: expected finite numbers up to {FARTHEST:g}, m"
        )


def check_region(region: ArrayLike, known: tuple[int, ...]) -> None:
    """Raise InputError if the region of a triangle, of shape (m,), is not one of those known."""
    values = np.asarray(region).ravel()
    bad = np.flatnonzero(~np.isin(values, known))
    if len(bad):
        raise InputError(
            f"triangle {bad[0]} has region = {values[bad[0]]:g}: "
            f"expected {' or '.join(map(str, known))}"
        )


def check_sheet(points: NDArray[np.float64], triangles: Indices) -> None:
    """Raise InputError unless points and triangles are one flat sheet.

    Parameters
    ----------
    points : (n, 2) array of float
        Finite coordinates, m.
    triangles : (m, 3) array of int
        Nodes of each triangle.
    """
    check_nodes(len(points), triangles)
    _check_none_isolated(len(points), triangles)
    _check_shapes(points, triangles)
    _check_edges(triangles)
    _check_one_piece(triangles)


def check_nodes(count: int, triangles: Indices) -> None:
    """Raise InputError if a triangle, of shape (m, 3), has a node that is not one of `count`."""
    outside = np.flatnonzero((triangles < 0).any(axis=1) | (triangles >= count).any(axis=1))
    if len(outside):
        raise InputError(f"{_named(triangles, outside[0])}: expected nodes from 0 to {count - 1}")


def _check_none_isolated(count: int, triangles: Indices) -> None:
    isolated = np.setdiff1d(np.arange(count), triangles)
    if len(isolated):
        raise InputError(
            f"node {isolated[0]} is isolated{_and_more(isolated)}: expected every node in a "
            "triangle"
        )


def doubled_areas_and_longest_sides(
    corners: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return twice the areas, m2, negative if clockwise, and the longest sides, m, of triangles.

    Parameters
    ----------
    corners : (m, 3, 2) array of float
        Of each triangle, m.
    """
    sides = corners - np.roll(corners, 1, axis=1)
    doubled = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
    return doubled, np.linalg.norm(sides, axis=2).max(axis=1)


def _check_shapes(points: NDArray[np.float64], triangles: Indices) -> None:
    doubled, longest = doubled_areas_and_longest_sides(points[triangles])
    flat = np.flatnonzero(np.abs(doubled) <= SLIVER * longest**2)
    if len(flat):
        raise InputError(
            f"{_named(triangles, flat[0])} is degenerate, its area is "
            f"{doubled[flat[0]] / 2:.3g} m2{_and_more(flat)}: expected a height of more than "
            f"{SLIVER:g} of the longest edge"
        )
    _, first, copies = np.unique(np.sort(triangles), axis=0, return_index=True, return_counts=True)
    if np.any(copies > 1):
        one = first[copies > 1].min()
        alike = np.flatnonzero((np.sort(triangles) == np.sort(triangles[one])).all(axis=1))
        raise InputError(
            f"{_named(triangles, one)} is there again as triangle {alike[1]}: expected each once"
        )
    clockwise = np.flatnonzero(doubled < 0)
    if len(clockwise):
        raise InputError(
            f"{_named(triangles, clockwise[0])} runs clockwise{_and_more(clockwise)}: expected "
            "counterclockwise nodes in all"
        )


def _check_edges(triangles: Indices) -> None:
    """At an edge lies one triangle or two, and they pass along it in opposite directions."""
    ends, count = directed_edges(triangles), len(triangles)
    edge = _numbers_of(np.sort(ends))
    crowded = np.flatnonzero(np.bincount(edge) > 2)
    if len(crowded):
        at = np.flatnonzero(edge == crowded[0])
        raise InputError(
            f"{_edge_named(ends[at[0]])} belongs to {len(at)} triangles "
            f"({_listed(np.sort(at % count))}): expected at most 2"
        )
    same_way = np.flatnonzero(np.bincount(_numbers_of(ends)) > 1)
    if len(same_way):
        at = np.flatnonzero(_numbers_of(ends) == same_way[0])
        raise InputError(
            f"triangles {_listed(np.sort(at % count))} lie on the same side of "
            f"{_edge_named(ends[at[0]])}: expected one on either side"
        )


def _check_one_piece(triangles: Indices) -> None:
    piece = _pieces(_numbers_of(np.sort(directed_edges(triangles))).reshape(3, -1))
    pieces = len(np.unique(piece))
    if pieces > 1:
        apart = int(np.argmax(piece != piece[0]))
        raise InputError(
            f"the mesh is in {pieces} pieces, {_named(triangles, apart)} shares no edge with that "
            f"of triangle 0: expected one"
        )


def _pieces(edge: Indices) -> Indices:
    """Return the lowest triangle of the piece in which each triangle lies, shape (m,).

    Every triangle takes the lowest number around it, and hands it to the one whose number it had
    (Shiloach and Vishkin 1982). scipy's `connected_components` takes longer to load than this.

    Parameters
    ----------
    edge : (3, m) array of int
        Numbers of the edges of each triangle.
    """
    piece = np.arange(edge.shape[1])
    while True:
        lowest = np.full(edge.max() + 1, len(piece))
        np.minimum.at(lowest, edge, piece[None])
        around = lowest[edge].min(axis=0)
        if np.array_equal(around, piece):
            return piece
        handed = piece.copy()
        np.minimum.at(handed, piece, around)
        while not np.array_equal(handed, handed[handed]):
            handed = handed[handed]
        piece = handed


def check_covers_once(points: NDArray[np.float64], triangles: Indices) -> None:
    """Raise InputError if a place of the plane lies in two triangles of a sheet.

    So it does on a mesh that is wound around twice. No specimen is such a sheet, though a shell of
    its own may be, such as a ring that is slit and overlaps.
    """
    corners = points[triangles]
    tree = shapely.STRtree(shapely.polygons(corners))
    place, holder = tree.query(shapely.points(corners.mean(axis=1)), predicate="within")
    twice = np.flatnonzero(place != holder)
    if len(twice):
        one, other = place[twice[0]], holder[twice[0]]
        raise InputError(
            f"{_named(triangles, one)} lies on triangle {other}"
            f"{_and_more(np.unique(place[twice]))}: expected a sheet that covers each place once"
        )


def _numbers_of(pairs: Indices) -> Indices:
    """Return a number for each pair of nodes, the same for equal pairs, counted from 0."""
    one = pairs[:, 0] * (pairs.max() + 1) + pairs[:, 1]
    return np.unique(one, return_inverse=True)[1].reshape(-1)


def _named(triangles: Indices, index: int) -> str:
    return f"triangle {index} (nodes {_listed(triangles[index])})"


def _edge_named(ends: Indices) -> str:
    return f"the edge of nodes {ends.min()} and {ends.max()}"


def _listed(numbers: Indices) -> str:
    return ", ".join(map(str, numbers))


def _and_more(found: Indices) -> str:
    return f" (as are {len(found) - 1} more)" if len(found) > 1 else ""
