"""Drawings in SVG, by svgelements: transforms, groups and `use` applied, curves flattened."""

import io
import math
import re
import xml.etree.ElementTree as ElementTree
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.drawings.lines import Curve, Line, Points, flattened
from bilayer.drawings.packages import package
from bilayer.drawings.svg_tree import GROUPS, LENGTHS, NAMESPACE, SEPARATOR, prepare
from bilayer.errors import InputError

DISTORTED = (
    "the file's preserveAspectRatio gives x and y other scales, or shows a part alone: expected "
    "unit = 'mm' or another"
)


class SvgDocument:
    """An SVG file; see `bilayer.drawings.lines.Document`.

    Its unit is that of the user coordinates: width and height over the size of the viewBox.

    Raises
    ------
    InputError
        It cannot be read.
    """

    how_to_tell = (
        "the file has no width in mm, cm or in beside a viewBox: expected unit = 'mm' or another, "
        "or dpi = 96 (Inkscape, browsers) or 72 (Illustrator)"
    )

    def __init__(self, path: Path) -> None:
        self._svgelements = package("svgelements")
        try:
            root = ElementTree.fromstring(path.read_bytes())
        except (OSError, ElementTree.ParseError, ValueError, LookupError) as error:
            reason = getattr(error, "strerror", None) or f"not an SVG file: {error}"
            raise InputError(f"drawing = {str(path)!r}: cannot be read ({reason})") from error
        if root.tag != f"{NAMESPACE}svg":
            raise InputError(
                f"drawing = {str(path)!r}: cannot be read (not an SVG file: its root is {root.tag})"
            )
        box = _view_box(root)
        self.unit = _unit(root, box)
        if _is_distorted(root, box):
            self.unit, self.how_to_tell = None, DISTORTED
        try:
            prepare(root)
        except InputError as error:
            raise InputError(f"drawing = {str(path)!r}: {error}") from error
        self._root, self._box = root, box

    def lines(self, tolerance: float) -> list[Line]:  # noqa: D102
        found = []
        for shape in self._shapes():
            try:
                found += self._lines_of(shape, tolerance)
            except (TypeError, ValueError) as error:  # a length such as 1em is no number
                name = shape.values.get("id") or shape.values.get("tag") or "one"
                raise InputError(
                    f"drawing: element {name!r} cannot be read, expected lengths in numbers"
                ) from error
        return found

    def _lines_of(self, shape: Any, tolerance: float) -> list[Line]:
        matrix, path = shape.transform, shape
        if not isinstance(shape, self._svgelements.Path):
            path = self._svgelements.Path(shape.segments(transformed=False))
        parts = (
            _subpath(self._svgelements, list(part), matrix, tolerance)
            for part in path.as_subpaths()
        )
        told = _layers(shape), _colour(shape), _is_hidden(shape)
        return [Line(points, closed, *told) for points, closed in parts if len(points) > 1]

    def upright(self, points: Points) -> Points:  # noqa: D102
        return points * [1, -1]

    def _shapes(self) -> list[Any]:
        """Return all that is drawn, in user coordinates: without the viewBox' transform."""
        for name in ("width", "height", "viewBox", "preserveAspectRatio"):
            self._root.attrib.pop(name, None)
        if self._box is not None:  # what lengths in per cent are of
            width, height = self._box[2:]
            self._root.attrib |= {"width": f"{width!r}", "height": f"{height!r}"}
            self._root.set("viewBox", f"0 0 {width!r} {height!r}")
        text = io.BytesIO(ElementTree.tostring(self._root))
        try:
            svg = self._svgelements.SVG.parse(text, reify=False)
            shapes = list(svg.select(lambda e: isinstance(e, self._svgelements.Shape)))
        except (ValueError, TypeError, IndexError, AttributeError, KeyError) as error:
            raise InputError(f"drawing: an element cannot be read ({error})") from error
        return shapes


def _subpath(
    svgelements: Any, segments: list[Any], matrix: Any, tolerance: float
) -> tuple[Points, bool]:
    """Return the points of a subpath in user coordinates, and whether it is closed."""
    pieces: list[Points] = []
    closed = False
    for segment in segments:
        if isinstance(segment, svgelements.Move):
            pieces.append(_moved(matrix, [segment.end]))
        elif isinstance(segment, svgelements.Close):
            closed = True
        elif isinstance(segment, svgelements.Line):
            pieces.append(_moved(matrix, [segment.end]))
        else:
            curve = _curve(svgelements, segment)
            moved = partial(_mapped, matrix, curve)
            pieces.append(flattened(moved, [0.0, 1.0], tolerance)[1:])
    points = np.concatenate(pieces) if pieces else np.empty((0, 2))
    if len(points) > 2 and np.linalg.norm(points[0] - points[-1]) <= tolerance:
        points, closed = points[:-1], True
    return points, closed


def _curve(svgelements: Any, segment: Any) -> Curve:
    """Return the points of an arc or a Bezier curve at parameters from 0 to 1."""
    if isinstance(segment, svgelements.Arc):
        centre, first, sweep = segment.center, segment.get_start_t(), segment.sweep
        axes = np.array([(p.x - centre.x, p.y - centre.y) for p in (segment.prx, segment.pry)])

        def ellipse(t: NDArray[np.float64]) -> Points:
            at = first + sweep * t
            return np.array([centre.x, centre.y]) + np.column_stack([np.cos(at), np.sin(at)]) @ axes

        return ellipse
    controls = np.array([(point.x, point.y) for point in segment])
    degree = len(controls) - 1

    def bezier(t: NDArray[np.float64]) -> Points:
        weights = [math.comb(degree, k) * t**k * (1 - t) ** (degree - k) for k in range(degree + 1)]
        return np.column_stack(weights) @ controls

    return bezier


def _moved(matrix: Any, points: list[Any]) -> Points:
    places = np.array([(point.x, point.y) for point in points], dtype=float)
    return _mapped(matrix, lambda _: places, None)


def _mapped(matrix: Any, curve: Curve, t: Any) -> Points:
    """Return points of a curve in user coordinates."""
    linear = np.array([[matrix.a, matrix.b], [matrix.c, matrix.d]], dtype=float)
    return np.asarray(curve(t) @ linear + [float(matrix.e), float(matrix.f)])


def _layers(shape: Any) -> tuple[str, ...]:
    names = shape.values.get(GROUPS, "").split(SEPARATOR)
    known = [*names, *map(_unescaped, names)]
    return tuple(dict.fromkeys(name for name in known if name))


def _unescaped(name: str) -> str:
    """Return a name without the escapes of Illustrator and CorelDraw: "cut_x20_1" is "cut 1"."""
    return re.sub(r"_x((?:[0-9A-Fa-f]{2}){1,2})_", lambda found: chr(int(found[1], 16)), name)


def _colour(shape: Any) -> str:
    """Return the colour of the stroke, or else of the fill."""
    for paint in (shape.stroke, shape.fill):
        if paint is not None and paint.value is not None:
            return str(paint.hexrgb)
    return ""


def _is_hidden(shape: Any) -> bool:
    values = shape.values
    if values.get("display") == "none" or values.get("visibility") in ("hidden", "collapse"):
        return True
    return all(paint is not None and paint.value is None for paint in (shape.stroke, shape.fill))


def _view_box(root: ElementTree.Element) -> tuple[float, float, float, float] | None:
    numbers = re.split(r"[\s,]+", root.get("viewBox", "").strip())
    try:
        x, y, width, height = (float(number) for number in numbers)
    except ValueError:
        return None
    return (x, y, width, height) if width > 0 and height > 0 else None


def _unit(root: ElementTree.Element, box: tuple[float, float, float, float] | None) -> float | None:
    """Return one user unit, m, where width or height and the viewBox say it."""
    if box is None:
        return None
    sizes = zip((root.get("width"), root.get("height")), box[2:], strict=True)
    scales = [size / extent for text, extent in sizes if (size := _length(text)) is not None]
    return min(scales, default=None)  # preserveAspectRatio: all of the box is seen


def _is_distorted(root: ElementTree.Element, box: tuple[float, float, float, float] | None) -> bool:
    """Whether x and y have other scales, or a part of the viewBox is cut off."""
    kept = root.get("preserveAspectRatio", "").split()
    if box is None or not {"none", "slice"}.intersection(kept):
        return False
    sizes = _length(root.get("width")), _length(root.get("height"))
    scales = [s / extent for s, extent in zip(sizes, box[2:], strict=True) if s is not None]
    return bool(scales) and not math.isclose(min(scales), max(scales), rel_tol=1e-6)


def _length(text: str | None) -> float | None:
    parts = re.fullmatch(r"\s*([-+.\deE]+?)\s*(mm|cm|in|pt|pc|q)\s*", text or "", re.IGNORECASE)
    try:
        size = float(parts[1]) * LENGTHS[parts[2].lower()] if parts else math.nan
    except ValueError:
        return None
    return size if math.isfinite(size) and size > 0 else None
