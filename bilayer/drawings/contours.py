"""Closed contours from the lines of a drawing: ends joined, and checked to bound a region."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.drawings.lines import Line, Points
from bilayer.errors import InputError

TOUCH = 1e-7
"""Contours that overlap in a band as narrow as this only touch, m."""


def closed_contours(lines: Sequence[Line], joint: float) -> list[Points]:
    """Return the closed contours that lines make, each point once.

    Parameters
    ----------
    lines : sequence of Line
        Points in m.
    joint : float
        Ends of lines that are nearer to each other than this are joined, m.

    Returns
    -------
    list of ndarray, shape (k, 2)
        m.

    Raises
    ------
    InputError
        A contour is open, drawn twice, crosses itself or another; with the place, (x, y) in mm.

    Examples
    --------
    >>> import numpy as np
    >>> corner = Line(np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]), False, ("cut",), "")
    >>> third = Line(np.array([(1.0, 1.0), (0.0, 0.0)]), False, ("cut",), "")
    >>> [len(contour) for contour in closed_contours([corner, third], 1e-5)]
    [3]
    """
    closed = [line.points for line in lines if line.closed]
    opened = [line.points for line in lines if not line.closed and length(line.points) > joint]
    rings = [_distinct(ring, joint) for ring in (*closed, *_joined(opened, joint))]
    rings = [ring for ring in rings if len(ring) > 2]
    _check_each(rings)
    _check_pairs(rings, joint)
    return rings


def even_odd(rings: Sequence[Points]) -> shapely.Geometry:
    """Return what lies within an odd number of rings, m."""
    parts = np.array([shapely.Polygon(), *map(shapely.Polygon, rings)], dtype=object)
    parts = parts[np.argsort(-shapely.area(parts), kind="stable")]
    while len(parts) > 1:  # by pairs: one after the other costs the square of their number
        last = parts[len(parts) // 2 * 2 :]
        parts = np.concatenate([shapely.symmetric_difference(parts[:-1:2], parts[1::2]), last])
    return parts[0]


def place(point: Sequence[float]) -> str:
    """Return a point in m as a text in mm."""
    x, y = (round(1e3 * float(value), 4) + 0.0 for value in point)
    return f"({x:g}, {y:g}) mm"


def _joined(lines: list[Points], joint: float) -> list[Points]:
    """Return the rings that open lines make, end to end."""
    if not lines:
        return []
    ends, near = near_ends(lines, joint)
    node = groups(len(ends), near)
    _check_repeats(lines, node, joint)
    count = np.bincount(node)
    if (count != 2).any():
        worst = int(np.flatnonzero(count != 2)[0])
        where = place(ends[node == worst][0])
        if count[worst] == 1:
            raise InputError(
                f"open contour: it ends at {where}, expected closed ones, or slit = the width of "
                "lines that are cut"
            )
        raise InputError(
            f"{count[worst]} lines meet at {where}, expected contours apart from each other"
        )
    middle = np.array([ends[node == n].mean(axis=0) for n in range(len(count))])
    lines = [
        np.concatenate([middle[[node[2 * k]]], line[1:-1], middle[[node[2 * k + 1]]]])
        for k, line in enumerate(lines)
    ]
    other_end = {int(a): int(b) for a, b in (np.flatnonzero(node == n) for n in np.unique(node))}
    other_end |= {b: a for a, b in other_end.items()}
    return _walked(lines, other_end)


def length(points: Points) -> float:
    """Return the length of a line; one no longer than a joint is a dot, and joins nothing."""
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def near_ends(lines: Sequence[Points], joint: float) -> tuple[Points, NDArray[np.intp]]:
    """Return the ends of lines, (2 n, 2), the first and the last of each, and the joined pairs."""
    from scipy.spatial import cKDTree  # slow to load

    ends = np.array([line[k] for line in lines for k in (0, -1)])
    return ends, cKDTree(ends).query_pairs(joint, output_type="ndarray")


def groups(count: int, pairs: NDArray[np.intp]) -> NDArray[np.int32]:
    """Return the number of the group of each of so many, which pairs join."""
    from scipy.sparse import coo_matrix  # slow to load
    from scipy.sparse.csgraph import connected_components

    links = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(count, count))
    return np.asarray(connected_components(links, directed=False)[1])


def _walked(lines: list[Points], partner: dict[int, int]) -> list[Points]:
    """Return the rings; end 2 k is the first of line k, 2 k + 1 its last, partners are joined."""
    rings = []
    left = dict.fromkeys(range(len(lines)))
    while left:
        end = start = 2 * next(iter(left))
        parts = []
        while True:
            left.pop(end // 2)
            parts.append(lines[end // 2] if end % 2 == 0 else lines[end // 2][::-1])
            end = partner[end ^ 1]
            if end == start:
                break
        rings.append(np.concatenate(parts))
    return rings


def _distinct(ring: Points, joint: float) -> Points:
    """Return a ring without points at which a line meets the next, joined within `joint`."""
    apart = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    shortest = min(joint, 1e-3 * float(np.median(apart))) if len(ring) else joint
    return ring[apart > shortest]


def _check_repeats(lines: list[Points], node: np.ndarray, joint: float) -> None:
    """Raise InputError if an open line is drawn twice."""
    by_ends: dict[tuple[int, ...], list[int]] = {}
    for number in range(len(lines)):
        by_ends.setdefault(tuple(sorted(node[2 * number : 2 * number + 2])), []).append(number)
    for numbers in by_ends.values():
        for a, b in combinations(numbers, 2):
            one, other = shapely.LineString(lines[a]), shapely.LineString(lines[b])
            if shapely.hausdorff_distance(one, other) <= joint:
                raise InputError(
                    f"a line is drawn twice, at {place(lines[a][len(lines[a]) // 2])}, "
                    "expected each once"
                )


def _check_each(rings: list[Points]) -> None:
    for ring in rings:
        polygon = shapely.Polygon(ring)
        if not polygon.is_valid:
            reason = shapely.is_valid_reason(polygon)
            where = reason.partition("[")[2].rstrip("]").split()
            at = place([float(value) for value in where]) if len(where) == 2 else place(ring[0])
            raise InputError(f"a contour crosses itself at {at}, expected one that does not")


def _check_pairs(rings: list[Points], joint: float) -> None:
    polygons = np.array([shapely.Polygon(ring) for ring in rings], dtype=object)
    bounds = shapely.bounds(polygons)
    tree = shapely.STRtree(polygons)
    for a, b in tree.query(polygons, predicate="intersects").T:
        if a >= b:
            continue
        one, other = polygons[a], polygons[b]
        alike = np.abs(bounds[a] - bounds[b]).max() <= joint  # the distance costs far more
        if alike and shapely.hausdorff_distance(one.exterior, other.exterior) <= joint:
            raise InputError(
                f"a contour is drawn twice, at {place(rings[a][0])}, expected each once"
            )
        common = shapely.intersection(one, other)
        smaller = min(one.area, other.area)
        overlap = common.area
        line = TOUCH * max(one.length, other.length)
        if line < overlap < smaller - line:
            crossing = shapely.intersection(one.exterior, other.exterior).representative_point()
            where = place((crossing.x, crossing.y))
            raise InputError(f"two contours cross at {where}, expected them apart")
