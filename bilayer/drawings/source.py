"""Where contours come from: a drawing, or an image, and how it is read."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bilayer.drawings.contours import closed_contours
from bilayer.drawings.dxf import DxfDocument
from bilayer.drawings.lines import Document, Line, Points
from bilayer.drawings.slits import with_slits, without_slits
from bilayer.drawings.svg import SvgDocument
from bilayer.errors import InputError
from bilayer.validation import nearest

READERS: dict[str, Callable[[Path], Document]] = {".dxf": DxfDocument, ".svg": SvgDocument}
"""By the ending of a file's name."""
ORIGINS = ("drawing", "centre")


@dataclass(frozen=True)
class DrawingSource:
    """A drawing and which of its contours are meant.

    Parameters
    ----------
    path : Path
        A file in DXF or SVG.
    layer : str or None
        Name of a layer; of a group in SVG. None: all of them.
    colour : str or None
        As "#rrggbb" or a name such as "red". None: all of them.
    unit : float or None
        One unit of the drawing, m; None: as the file says.
    tolerance : float
        Largest distance of the contours from curves, m.
    joint : float
        Ends of lines that are nearer to each other than this are joined, m.
    origin : {"drawing", "centre"} or (float, float)
        The point of the drawing that becomes the origin: its own, the centre of the smallest
        rectangle around all that is drawn, or one in m, y upwards.
    slit : float or None
        Lines that close no contour are slits of this width, m; None: they are refused.
    """

    path: Path
    layer: str | None = None
    colour: str | None = None
    unit: float | None = None
    tolerance: float = 1e-7
    joint: float = 1e-5
    origin: str | tuple[float, float] = "drawing"
    slit: float | None = None

    def contours(self) -> list[Points]:
        """Return the closed contours, y upwards, m, each of shape (k, 2).

        Raises
        ------
        InputError
            The file cannot be read or says no unit, the layer is not in it, or its lines bound
            nothing; see `bilayer.drawings.contours.closed_contours`.
        ComputationError
            A package that reads drawings is not there.
        """
        document = self._opened()
        unit = self.unit if self.unit is not None else document.unit
        if unit is None:
            raise InputError(f"unit: missing, {document.how_to_tell}")
        lines = document.lines(self.tolerance / unit)
        chosen = self._in_metres(_all_lines(self._chosen(lines)), unit)
        try:
            rings = self._bounding(chosen)
        except InputError as error:
            raise InputError(f"drawing = {self.path.name!r}: {error}") from error
        if not rings:
            raise InputError(f"drawing = {self.path.name!r}: expected closed contours, has none")
        origin = self._origin(document, lines, unit)
        upright = [document.upright(np.asarray(ring / unit, dtype=np.float64)) for ring in rings]
        return [unit * ring - origin for ring in upright]

    def _bounding(self, lines: Sequence[Line]) -> list[Points]:
        if self.slit is None:
            return closed_contours(lines, self.joint)
        closing, slits = without_slits(lines, self.joint)
        rings = closed_contours(closing, self.joint)
        return with_slits(rings, slits, self.slit) if slits else rings

    def _opened(self) -> Document:
        ending = self.path.suffix.lower()
        if ending not in READERS:
            known = " or ".join(READERS)
            raise InputError(f"drawing = {self.path.name!r}: expected a file in {known}")
        return READERS[ending](self.path)

    def _chosen(self, lines: Sequence[Line]) -> list[Line]:
        """Return the lines of the layer and the colour that are asked for."""
        chosen = _seen(lines)
        if self.layer is not None:
            chosen = _on_layer(lines, self.layer)
            if not chosen:
                known = list(dict.fromkeys(name for line in lines for name in line.layers))
                raise InputError(
                    f"layer = {self.layer!r}: nothing is drawn there, expected one of "
                    f"{', '.join(known) or 'none: the drawing has no layers'}"
                    f"{nearest(self.layer, known)}"
                )
        if self.colour is not None:
            wanted = hexadecimal(self.colour)
            known = list(dict.fromkeys(line.colour for line in chosen if line.colour))
            chosen = [line for line in chosen if line.colour == wanted]
            if not chosen:
                raise InputError(
                    f"colour = {self.colour!r}: nothing is drawn in it, expected one of "
                    f"{', '.join(known)}"
                )
        return chosen

    def _origin(self, document: Document, lines: Sequence[Line], unit: float) -> Points:
        if self.origin == "drawing":
            return np.zeros(2)
        if self.origin == "centre":
            drawn = document.upright(np.concatenate([line.points for line in _extent(lines)]))
            return unit * (drawn.min(axis=0) + drawn.max(axis=0)) / 2
        return np.asarray(self.origin, dtype=float)

    @staticmethod
    def _in_metres(lines: Sequence[Line], unit: float) -> list[Line]:
        return [replace(line, points=unit * line.points) for line in lines]


def _seen(lines: Sequence[Line]) -> list[Line]:
    """Return the lines that are not hidden; all of them if nothing is seen."""
    return [line for line in lines if not line.hidden] or list(lines)


def _extent(lines: Sequence[Line]) -> list[Line]:
    """Return the lines whose middle is the centre of the drawing; surfaces have no points."""
    return _seen([line for line in lines if not line.strange])


def _on_layer(lines: Sequence[Line], layer: str) -> list[Line]:
    """Return the lines of a layer, hidden or not; small and capital letters differ where both are.

    To DXF they are the same.
    """
    exact = [line for line in lines if layer in line.layers]
    wanted = layer.casefold()
    return exact or [line for line in lines if wanted in map(str.casefold, line.layers)]


def _all_lines(chosen: list[Line]) -> list[Line]:
    """Raise InputError if something else is among them, which bounds nothing."""
    for line in chosen:
        if line.strange:
            raise InputError(
                f"drawing: has a {line.strange} on layer {line.layers[-1]!r}, expected lines, arcs "
                "and splines"
            )
    return chosen


def hexadecimal(colour: str) -> str:
    """Return a colour as "#rrggbb"; raise InputError unless it is one."""
    from matplotlib.colors import to_hex  # slow to load

    try:
        return str(to_hex(colour))
    except ValueError:
        raise InputError(f"colour = {colour!r}: expected one such as 'red' or '#ff0000'") from None
