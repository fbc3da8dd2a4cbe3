"""Slits: lines of a drawing that close no contour, cut with a width."""

from collections.abc import Sequence

import numpy as np
import shapely

from bilayer.drawings.contours import even_odd, groups, length, near_ends
from bilayer.drawings.lines import Line, Points

MITRE = 5.0
"""Corners of a slit are sharp up to this length over half its width."""


def without_slits(lines: Sequence[Line], joint: float) -> tuple[list[Line], list[Points]]:
    """Return the lines that close contours, alone or together, and the points of the others.

    Parameters
    ----------
    lines : sequence of Line
        Points in m.
    joint : float
        Ends of lines that are nearer to each other than this are joined, m.

    Examples
    --------
    >>> import numpy as np
    >>> square = Line(np.array([(0.0, 0.0), (1, 0), (1, 1), (0, 1)]), True, ("cut",), "")
    >>> slit = Line(np.array([(2.0, 0.0), (3.0, 0.0)]), False, ("cut",), "")
    >>> closing, slits = without_slits([square, slit], 1e-5)
    >>> len(closing), len(slits)
    (1, 1)
    """
    opened = [line for line in lines if not line.closed and length(line.points) > joint]
    closed = [line for line in lines if line.closed]
    if not opened:
        return closed, []
    ends, near = near_ends([line.points for line in opened], joint)
    node = groups(len(ends), near)
    chain = groups(len(ends), np.concatenate([near, np.arange(len(ends)).reshape(-1, 2)]))
    is_loose = np.bincount(node)[node] != 2
    has_loose = np.bincount(chain, is_loose) > 0
    is_slit = has_loose[chain[::2]]
    closing = [line for line, loose in zip(opened, is_slit, strict=True) if not loose]
    slits = [line.points for line, loose in zip(opened, is_slit, strict=True) if loose]
    return [*closed, *closing], slits


def with_slits(rings: Sequence[Points], slits: Sequence[Points], width: float) -> list[Points]:
    """Return the rings around what rings bound, by even-odd, and slits of a width, m.

    A slit ends where its line does, across it.

    Examples
    --------
    >>> import numpy as np
    >>> (ring,) = with_slits([], [np.array([(0.0, 0.0), (0.01, 0.0)])], 1e-3)
    >>> float(np.ptp(ring[:, 1]).round(6))
    0.001
    """
    cut = [
        shapely.LineString(points).buffer(
            width / 2, cap_style="flat", join_style="mitre", mitre_limit=MITRE
        )
        for points in slits
    ]
    region = shapely.union_all([even_odd(rings), *cut])
    polygons = [part for part in shapely.get_parts(region) if part.area > 0]
    return [
        np.asarray(ring.coords, dtype=np.float64)[:-1]
        for polygon in polygons
        for ring in (polygon.exterior, *polygon.interiors)
    ]
