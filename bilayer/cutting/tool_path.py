"""The closed lines along which a cutter moves, half a kerf outside of the part."""

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.specimen.drawn import offset
from bilayer.specimen.outline import rings_of


def tool_path(region: shapely.Geometry, kerf: float) -> list[NDArray[np.float64]]:
    """Return the lines to cut, each once and closed, in the order in which they are cut.

    What lies within another line comes before it: what is cut out no longer lies still.

    Parameters
    ----------
    region : Polygon or MultiPolygon
        The part, m.
    kerf : float
        Width of the cut, m; the part keeps its size.

    Returns
    -------
    list of ndarray, shape (k, 2)
        Points of each, the first not repeated, m.
    """
    path = [np.array(ring) for ring in rings_of(offset(region, kerf / 2) if kerf else region)]
    areas = [shapely.Polygon(ring) for ring in path]
    starts = [shapely.Point(ring[0]) for ring in path]
    depth = [sum(area.contains(start) for area in areas) for start in starts]
    return [path[k] for k in np.argsort([-d for d in depth], kind="stable")]


def registration_marks(sheet: shapely.Geometry, arm: float = 2e-3) -> list[NDArray[np.float64]]:
    """Return the lines of three crosses beside a sheet, two below it and one above, m.

    Layers whose marks lie over each other, a stretched one's when it is stretched, lie as they are
    bonded. Three, not four: a part that was
    turned over or around does not fit them.
    """
    x, y, far_x, far_y = sheet.bounds
    away = 2 * arm
    corners = [(x - away, y - away), (far_x + away, y - away), (x - away, far_y + away)]
    arms = np.array([[(-arm, 0.0), (arm, 0.0)], [(0.0, -arm), (0.0, arm)]])
    return [line + np.array(corner) for corner in corners for line in arms]
