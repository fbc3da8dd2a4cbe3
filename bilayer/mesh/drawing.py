"""The drawing of a flat sheet in gmsh: surfaces on each of which the same layers lie.

A disc whose layers are whole or cut by the same sectors is drawn with arcs (`sector_disc`), any
other sheet by its outline and the edges of its patterns (`divided_sheet`).
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

TRIANGLES_PER_AREA = 1.2 * 4 / math.sqrt(3)
"""Times the square of the mesh size: 1.2 (measured) times as many as equilateral ones."""


class DrawnPart(NamedTuple):
    """Surfaces in gmsh on which the same layers lie.

    Parameters
    ----------
    surfaces : sequence of int
        Their tags.
    layers : frozenset of str
        Names of the layers.
    """

    surfaces: Sequence[int]
    layers: frozenset[str]


class Drawing(Protocol):
    """A flat sheet that can draw itself."""

    def draw(self, gmsh: Any) -> list[DrawnPart]:
        """Draw it into gmsh's current model, synchronised, with its mesh sizes."""

    def triangles(self) -> float:
        """Return the number of triangles to expect."""
