"""How far drawn contours reach beyond the sheet, where nothing is left of them."""

from collections.abc import Iterator, Mapping

import numpy as np
import shapely

from bilayer.drawings.contours import place
from bilayer.errors import InputError
from bilayer.runtime.terminal import Notice
from bilayer.specimen.outline import Outline
from bilayer.specimen.pattern import Contours
from bilayer.specimen.specimen import Specimen
from bilayer.specimen.tables import Tables

TOLD, REFUSED = 0.1, 1.0
"""Over the characteristic length: a cut that is to open the rim overruns it, but not so far."""


def check_reach(tables: Tables, specimen: Specimen, notice: Notice) -> None:
    """Raise InputError if a drawn pattern reaches far beyond the sheet: another unit or origin.

    Parameters
    ----------
    tables : mapping
        Of the specimen file, with its drawings.
    specimen : Specimen
        What was made of them.
    notice : callable
        Takes a line for the user if it reaches less far.
    """
    for number, pattern in _drawn_patterns(tables, specimen):
        distance, point = _reach(pattern, specimen.outline)
        share = distance / specimen.characteristic_length
        words = (
            f"layers[{number}].pattern: what is drawn reaches {1e3 * distance:.3g} mm beyond the "
            f"sheet, to {place(point)} from its origin"
        )
        if share > REFUSED:
            raise InputError(f"{words}; expected it on the sheet, are unit and origin right?")
        if share > TOLD:
            notice(f"{words}; it is cut off at the rim")


def _drawn_patterns(tables: Tables, specimen: Specimen) -> Iterator[tuple[int, Contours]]:
    if "layers" not in tables:
        return  # the short form has no drawings
    named = tables.get("patterns", {})
    given = [layer.get("pattern") for layer in tables["layers"]]
    for number, (table, layer) in enumerate(zip(given, specimen.layers, strict=True)):
        table = named.get(table) if isinstance(table, str) else table
        is_drawing = isinstance(table, Mapping) and "drawing" in table
        if is_drawing and isinstance(layer.pattern, Contours):
            yield number, layer.pattern


def _reach(pattern: Contours, outline: Outline) -> tuple[float, tuple[float, float]]:
    """Return the largest distance of a contour from the sheet, and where, m; holes count as it."""
    points = np.concatenate([np.asarray(contour) for contour in pattern.contours])
    sheet = shapely.Polygon(outline.polygon.exterior)
    shapely.prepare(sheet)
    beyond = points[~shapely.contains_xy(sheet, *points.T)]  # few; the distance costs far more
    if len(beyond) == 0:
        return 0.0, (0.0, 0.0)
    away = shapely.distance(sheet, shapely.points(beyond))
    farthest = int(np.argmax(away))
    x, y = beyond[farthest]
    return float(away[farthest]), (float(x), float(y))
