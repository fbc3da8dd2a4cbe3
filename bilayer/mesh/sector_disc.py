"""A disc whose layers are whole or cut by the same sectors, drawn with arcs.

The disc is drawn as the part that all layers cover and its cutouts, sharing the cut edges; the
centre is a node, because it is the one that the paper's method holds.
"""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bilayer.mesh.drawing import TRIANGLES_PER_AREA, DrawnPart
from bilayer.specimen.outline import Disc
from bilayer.specimen.pattern import CutPattern
from bilayer.specimen.specimen import MeshSize, Specimen


@dataclass(frozen=True)
class SectorDisc:
    """A disc and its sectors.

    Parameters
    ----------
    radius : float
        Of the disc, m.
    cut : CutPattern or None
        The sectors that are cut out of some of the layers.
    mesh : MeshSize
        Edge lengths, finer at the cutouts' inner corners.
    everywhere, in_strips : frozenset of str
        Names of the whole layers; of all layers.
    """

    radius: float
    cut: CutPattern | None
    mesh: MeshSize
    everywhere: frozenset[str]
    in_strips: frozenset[str]

    @classmethod
    def of(cls, specimen: Specimen) -> "SectorDisc | None":
        """Return the disc that a specimen is; None if it is something else."""
        cuts = {layer.pattern for layer in specimen.layers if layer.pattern is not None}
        cut = next(iter(cuts), None)
        everywhere = frozenset(layer.name for layer in specimen.layers if layer.is_whole)
        if (
            not isinstance(specimen.outline, Disc)
            or not isinstance(cut, CutPattern | None)
            or len(cuts) > 1
            or specimen.drawn_lines
            or not everywhere
        ):
            return None
        names = frozenset(specimen.layer_names)
        return cls(specimen.outline.radius, cut, specimen.mesh, everywhere, names)

    def triangles(self) -> float:
        """Return the number of triangles to expect.

        Their size goes linearly from the corners' at the inner radius to the mesh's at the rim.
        Strips and cutouts narrower than that are a row of two triangles for every length of it.
        """
        radius, size = self.radius, self.mesh.size
        finest, inner = size, 0.0
        if self.cut is not None and self.mesh.corner_size is not None:
            finest, inner = self.mesh.corner_size, self.cut.inner_radius
        rings = 10_000
        r = (np.arange(rings) + 0.5) * radius / rings
        with np.errstate(over="ignore", divide="ignore"):
            local_size = np.interp(r, [0.0, inner, radius], [size, finest, size])
            per_area = TRIANGLES_PER_AREA / local_size**2
            sectors, angle = self._sectors(r)
            in_each = np.maximum(per_area * angle * r, 2 / local_size)
            return float(np.sum(sectors * in_each) * radius / rings)

    def draw(self, gmsh: Any) -> list[DrawnPart]:
        """Draw the disc; see `bilayer.mesh.drawing.Drawing`."""
        geo = gmsh.model.geo
        centre = geo.addPoint(0, 0, 0, self.mesh.size)
        pen = _Pen(geo, centre)
        if self.cut is None:
            start = pen.point(self.radius, 0.0, self.mesh.size)
            rim = (self.radius, self.mesh.size)
            outline = pen.arcs(start, start, 0.0, 2 * math.pi, *rim)
            bare: list[int] = []
        else:
            outline, bare = self._draw_cuts(pen, self.cut)
        disc = geo.addPlaneSurface([geo.addCurveLoop(outline)])
        geo.synchronize()
        gmsh.model.mesh.embed(0, [centre], 2, disc)
        return [DrawnPart([disc], self.in_strips), DrawnPart(bare, self.everywhere)]

    def _sectors(self, r: NDArray[np.float64]) -> tuple[Any, NDArray[np.float64]]:
        """Return the number of sectors and their angle: all around, or strips and cutouts."""
        cut = self.cut
        if cut is None:
            return 1, np.full_like(r, 2 * math.pi)
        strip = 2 * math.pi / cut.strips - cut.cutout_angle
        angles = np.array([[strip], [cut.cutout_angle]])
        inside = r < cut.inner_radius
        return np.where(inside, 0.5, cut.strips), np.where(inside, 2 * math.pi, angles)

    def _draw_cuts(self, pen: "_Pen", cut: CutPattern) -> tuple[list[int], list[int]]:
        """Draw the cutouts; return the outline of the strips' part and the cutouts' surfaces."""
        cutouts = [self._draw_cutout(pen, cut, middle) for middle in cut.cutout_centres]
        outline: list[int] = []
        for here, following in zip(cutouts, [*cutouts[1:], cutouts[0]], strict=True):
            end_angle = following.first_angle
            if end_angle <= here.last_angle:
                end_angle += 2 * math.pi
            strip_rim = pen.arcs(
                here.rim_end, following.rim_start, here.last_angle, end_angle,
                self.radius, self.mesh.size,
            )  # fmt: skip
            outline += [*here.cut_edges, *strip_rim]
        return outline, [cutout.surface for cutout in cutouts]

    def _draw_cutout(self, pen: "_Pen", cut: CutPattern, middle: float) -> "_Cutout":
        """Draw one cutout, bounded by two radial cuts, an inner arc and a piece of the rim."""
        size, corner_size = self.mesh.size, self.mesh.corner_size or self.mesh.size
        first, last = middle - cut.cutout_angle / 2, middle + cut.cutout_angle / 2
        corner_1 = pen.point(cut.inner_radius, first, corner_size)
        corner_2 = pen.point(cut.inner_radius, last, corner_size)
        rim_1 = pen.point(self.radius, first, size)
        rim_2 = pen.point(self.radius, last, size)
        inward, outward = pen.geo.addLine(rim_1, corner_1), pen.geo.addLine(corner_2, rim_2)
        inner_arcs = pen.arcs(corner_1, corner_2, first, last, cut.inner_radius, corner_size)
        rim_arcs = pen.arcs(rim_1, rim_2, first, last, self.radius, size)
        loop = [*rim_arcs, -outward, *[-arc for arc in reversed(inner_arcs)], -inward]
        surface = pen.geo.addPlaneSurface([pen.geo.addCurveLoop(loop)])
        return _Cutout(surface, [inward, *inner_arcs, outward], rim_1, rim_2, first, last)


class _Cutout(NamedTuple):
    """A drawn cutout: its surface, and the points and edges that it shares with the strips."""

    surface: int
    cut_edges: list[int]
    rim_start: int
    rim_end: int
    first_angle: float
    last_angle: float


class _Pen(NamedTuple):
    """Points and arcs around the centre, in gmsh's built-in geometry."""

    geo: Any
    centre: int

    def point(self, radius: float, angle: float, size: float) -> int:
        return self.geo.addPoint(radius * math.cos(angle), radius * math.sin(angle), 0, size)

    def arcs(
        self, start: int, end: int, first: float, last: float, radius: float, size: float
    ) -> list[int]:
        """Return the arc from `start` to `end`, in pieces: gmsh's are of less than half a turn."""
        pieces = math.ceil((last - first) / (2 * math.pi / 3) - 1e-9)
        angles = [first + (last - first) * k / pieces for k in range(1, pieces)]
        points = [start, *(self.point(radius, angle, size) for angle in angles), end]
        return [self.geo.addCircleArc(a, self.centre, b) for a, b in pairwise(points)]
