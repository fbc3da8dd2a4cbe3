"""Drawings in DXF, by ezdxf: inserts exploded, arcs, ellipses and splines flattened."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bilayer.drawings.lines import Line, Points, flattened
from bilayer.drawings.packages import package
from bilayer.errors import InputError

UNITS = {
    1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 8: 2.54e-8, 9: 2.54e-5, 10: 0.9144, 11: 1e-10,
    12: 1e-9, 13: 1e-6, 14: 0.1, 15: 10.0, 16: 100.0,
}  # fmt: skip
"""m, by the number of the header's $INSUNITS."""
ANNOTATIONS = (
    "TEXT", "MTEXT", "ATTRIB", "ATTDEF", "DIMENSION", "LEADER", "MULTILEADER", "POINT", "HATCH",
    "VIEWPORT", "IMAGE", "XLINE", "RAY", "WIPEOUT", "TOLERANCE", "ARC_DIMENSION", "ACAD_TABLE",
    "LARGE_RADIAL_DIMENSION", "PDFUNDERLAY", "DWFUNDERLAY", "DGNUNDERLAY", "OLE2FRAME",
)  # fmt: skip
"""Entities that are not cut, and are left out."""
CONTROL_POINT = 16
"""Among the flags of a VERTEX: of the frame of a spline."""
DEEPEST = 16
"""Of blocks within blocks."""
TURN = 2 * math.pi


@dataclass(frozen=True)
class Around:
    """What an entity is drawn on and with; what it takes from the insert around it.

    Parameters
    ----------
    layer : str
        Its name.
    colour : str
        As "#rrggbb".
    hidden : bool
        Whether nobody sees it, whatever its layer.
    """

    layer: str = "0"
    colour: str = ""
    hidden: bool = False


Drawn = tuple[Any, Around]
"""An entity of ezdxf and what it is drawn on."""


class DxfDocument:
    """A DXF file; see `bilayer.drawings.lines.Document`.

    Raises
    ------
    InputError
        It cannot be read.
    """

    how_to_tell = "the file's $INSUNITS names none: expected unit = 'mm' or another"

    def __init__(self, path: Path) -> None:
        ezdxf = package("ezdxf")
        try:
            self._document = ezdxf.readfile(path)
        except Exception as error:  # damaged files raise errors of every kind
            reason = getattr(error, "strerror", None) or f"not a DXF file: {error}"
            raise InputError(f"drawing = {str(path)!r}: cannot be read ({reason})") from error
        self._colours = package("ezdxf.colors")
        self._errors = ezdxf.DXFError
        self.unit: float | None = UNITS.get(self._document.header.get("$INSUNITS", 0))

    def lines(self, tolerance: float) -> list[Line]:  # noqa: D102
        drawn = self._entities(self._document.modelspace(), Around(), DEEPEST)
        try:
            return [self._line(*given, tolerance) for given in drawn]
        except self._errors as error:
            raise InputError(f"drawing: cannot be read ({error})") from error

    def _line(self, entity: Any, own: Around, tolerance: float) -> Line:
        hidden = own.hidden or not self._is_shown(own.layer)
        points = _points(entity, tolerance)
        if points is None:
            nothing = np.empty((0, 2))
            return Line(nothing, False, (own.layer,), own.colour, hidden, entity.dxftype())
        closed = len(points) > 2 and _is_closed(points)
        if closed and np.allclose(points[0], points[-1], rtol=0, atol=tolerance):
            points = points[:-1]
        return Line(points, closed, (own.layer,), own.colour, hidden)

    def _is_shown(self, name: str) -> bool:
        if name not in self._document.layers:
            return True
        layer = self._document.layers.get(name)
        return not (layer.is_off() or layer.is_frozen())

    def _is_frozen(self, name: str) -> bool:
        return name in self._document.layers and self._document.layers.get(name).is_frozen()

    def upright(self, points: Points) -> Points:  # noqa: D102
        return points

    def _entities(self, entities: Any, around: Around, depth: int) -> Iterator[Drawn]:
        """Yield what is drawn, inserts exploded, with its layer and colour.

        On layer "0" of a block things lie on the layer of its insert (the DXF reference, BLOCK).
        An insert on a frozen layer hides all of its block, one on a layer that is off does not.
        """
        for entity in entities:
            kind = entity.dxftype()
            layer = around.layer if entity.dxf.layer == "0" else entity.dxf.layer
            colour = self._colour(entity, layer, around.colour)
            hidden = around.hidden or bool(entity.dxf.get("invisible", 0))
            if kind == "INSERT":
                if depth == 0:
                    raise InputError(
                        f"drawing: block {entity.dxf.name!r} lies within {DEEPEST} others"
                    )
                within = Around(layer, colour, hidden or self._is_frozen(layer))
                for insert in entity.multi_insert() if entity.mcount > 1 else [entity]:
                    yield from self._entities(insert.virtual_entities(), within, depth - 1)
            elif kind not in ANNOTATIONS:
                yield entity, Around(layer, colour, hidden)

    def _colour(self, entity: Any, layer: str, of_insert: str) -> str:
        if entity.dxf.hasattr("true_color"):
            return _hexadecimal(entity.rgb)
        number = entity.dxf.color
        if number == 0:  # by block
            return of_insert
        if number == 256:  # by layer
            if layer not in self._document.layers:
                return "#000000"
            own = self._document.layers.get(layer)
            if own.dxf.hasattr("true_color"):
                return _hexadecimal(own.rgb)
            number = abs(own.color)
        if number == 7:  # black on white paper, white on a black screen
            return "#000000"
        return _hexadecimal(self._colours.aci2rgb(number))


def _hexadecimal(rgb: Any) -> str:
    return "#" + "".join(f"{part:02x}" for part in rgb)


def _points(entity: Any, tolerance: float) -> Points | None:
    """Return the points of an entity, in world coordinates, both ends among them.

    None of what is no line, such as a surface.
    """
    kind = entity.dxftype()
    if kind == "LINE":
        return _flat([entity.dxf.start, entity.dxf.end])
    if kind in ("ARC", "CIRCLE"):
        first, last = (
            (0.0, 360.0)
            if kind == "CIRCLE"
            else (entity.dxf.start_angle, entity.dxf.start_angle + _span(entity))
        )
        return flattened(lambda t: _flat(entity.vertices(t)), [first, last], tolerance)
    if kind == "ELLIPSE":
        tool = entity.construction_tool()
        span = (tool.end_param - tool.start_param) % TURN or TURN
        breaks = [tool.start_param, tool.start_param + span]
        return flattened(lambda t: _flat(tool.vertices(t)), breaks, tolerance)
    if kind == "SPLINE":
        tool = entity.construction_tool()
        knots = np.unique(np.asarray(tool.knots())[tool.degree : len(tool.knots()) - tool.degree])
        return flattened(lambda t: _flat(tool.points(t)), list(knots), tolerance)
    if kind == "POLYLINE":
        _drop_frame(entity)
    if kind == "LWPOLYLINE" or (kind == "POLYLINE" and entity.is_2d_polyline):
        parts = (_points(part, tolerance) for part in entity.virtual_entities())
        return _chained([part for part in parts if part is not None])
    if kind == "POLYLINE" and entity.is_3d_polyline:
        points = [vertex.dxf.location for vertex in entity.vertices]
        return _flat([*points, points[0]] if entity.is_closed else points)
    return None


def _drop_frame(polyline: Any) -> None:
    """Take out the control points of a smoothed polyline, whose curve is given as well."""
    polyline.vertices[:] = [v for v in polyline.vertices if not v.dxf.flags & CONTROL_POINT]


def _chained(parts: list[Points]) -> Points:
    """Return the parts of a polyline as one; bulges may be given end to start."""
    if not parts:
        return np.empty((0, 2))
    chain = parts[0]
    if len(parts) > 1 and min(_gaps(chain[:1], parts[1])) < min(_gaps(chain[-1:], parts[1])):
        chain = chain[::-1]
    for part in parts[1:]:
        near, far = _gaps(chain[-1:], part)
        chain = np.concatenate([chain, (part if near <= far else part[::-1])[1:]])
    return chain


def _gaps(end: Points, part: Points) -> tuple[float, float]:
    """Return the distances from an end to both ends of a part."""
    first, last = np.linalg.norm(part[[0, -1]] - end, axis=1)
    return float(first), float(last)


def _span(arc: Any) -> float:
    """Return the angle of an arc, counterclockwise, degrees."""
    return float((arc.dxf.end_angle - arc.dxf.start_angle) % 360 or 360)


def _is_closed(points: Points) -> bool:
    extent = np.ptp(points, axis=0).max()
    return bool(np.linalg.norm(points[0] - points[-1]) < 1e-9 * extent)


def _flat(points: Any) -> Points:
    """Return three-dimensional points seen from above."""
    return np.array([(point[0], point[1]) for point in points], dtype=float).reshape(-1, 2)
