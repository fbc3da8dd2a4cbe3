"""The axes and the unit in which a shape is written."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from bilayer.measures.body_frame import BodyFrame, body_frame
from bilayer.results.schema import result_mesh
from bilayer.validation import keep, one_of

Array = NDArray[np.float64]

UNITS = {"m": 1.0, "mm": 1e3}
"""Units of length, with the number of them in a metre."""
FRAMES = ("result", "body")
IN_MM = (".stl", ".obj", ".ply", ".off")
"""Endings of the formats of slicers and scanners. They say no unit, and mm is what is meant."""


def usual_unit(path: str | Path) -> str:
    """Return the unit of lengths in a file if none is asked for, by its ending: "mm" or "m"."""
    return "mm" if Path(path).suffix.lower() in IN_MM else "m"


@dataclass(frozen=True)
class Axes:
    """The frame and the unit of what is written.

    Parameters
    ----------
    frame : {"result", "body"}
        "result": places as `position` has them. "body": in the body frame of each shape, apex up.
    unit : {"m", "mm"}
        Of lengths.
    """

    frame: str = "result"
    unit: str = "m"

    def __post_init__(self) -> None:
        keep(self, one_of, "frame", choices=FRAMES)
        keep(self, one_of, "unit", choices=UNITS)

    @property
    def per_metre(self) -> float:
        """How many units a metre has."""
        return UNITS[self.unit]

    def of(self, shape: xr.Dataset) -> "Placing":
        """Return how the points of one milestone are placed."""
        frame = None
        if self.frame == "body":
            frame = body_frame(result_mesh(shape), shape["position"].values)
        return Placing(frame, self.per_metre)


@dataclass(frozen=True)
class Placing:
    """The way from a result's places and directions to those of a file."""

    frame: BodyFrame | None
    per_metre: float

    def points(self, position: Array) -> Array:
        """Return places (n, 3), m, in the file's axes and unit."""
        placed = position if self.frame is None else self.frame.coordinates(position)
        return self.per_metre * placed

    def directions(self, vectors: Array) -> Array:
        """Return directions (n, 3) in the file's axes."""
        return vectors if self.frame is None else vectors @ self.frame.axes.T
