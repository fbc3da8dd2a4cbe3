"""Any flat sheet, divided by the edges of its patterns into parts on which the same layers lie.

shapely finds the parts; their edges are cut into chains, smooth lines that end at corners and where
parts meet, each of them one curve of gmsh, so that the parts share their edges and gmsh sets the
nodes on them.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
import shapely
from shapely.geometry.polygon import orient

from bilayer.mesh.drawing import TRIANGLES_PER_AREA, DrawnPart
from bilayer.specimen.specimen import Specimen

SNAP = 1e-7
"""Points nearer to each other than this share of the characteristic length are one."""
CORNER = math.radians(20)
"""Edges that turn by more at a point have a corner there, which becomes a node."""
STRAIGHT = math.radians(30)
"""A curve of many short lines is given an edge for every such part of a turn, or more."""
MISFIT = 1 / 200
"""A part narrower than this share of the mesh size is the misfit of two edges meant as one."""
GRADING = 0.25
"""Growth of the edge length over the distance from the corners of the cuts."""

Vertex = tuple[float, float]
Chain = tuple[Vertex, ...]


@dataclass(frozen=True)
class Part:
    """A part of the sheet.

    Parameters
    ----------
    polygon : Polygon
        Where it lies, m.
    layers : frozenset of str
        Names of the layers there.
    """

    polygon: shapely.Polygon
    layers: frozenset[str]

    @property
    def rings(self) -> list[list[Vertex]]:
        """Its outer edge counterclockwise, then those of its holes, each corner once, m."""
        polygon = orient(self.polygon)
        return [list(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]

    @property
    def width(self) -> float:
        """Its width if it is a strip, m."""
        return 2 * self.polygon.area / self.polygon.length


@dataclass(frozen=True)
class DividedSheet:
    """The parts of a sheet.

    Parameters
    ----------
    parts : tuple of Part
        Where no layer lies there is none.
    outline : Polygon
        Of the sheet, m.
    centre : (float, float)
        Becomes a node if it lies well within a part, m.
    size : float
        Edge length of the mesh, m.
    corner_size : float
        Edge length at the corners of the cuts, m.
    """

    parts: tuple[Part, ...]
    outline: shapely.Polygon
    centre: Vertex
    size: float
    corner_size: float

    @classmethod
    def of(cls, specimen: Specimen) -> "DividedSheet":
        """Return the divided sheet of a specimen."""
        size = specimen.mesh.size
        corner_size = specimen.mesh.corner_size or size
        outline = specimen.outline
        return cls(divided(specimen), outline.polygon, outline.centroid, size, corner_size)

    def triangles(self) -> float:
        """Return the number of triangles to expect.

        Parts narrower than the mesh size are a row of two triangles for every length of it.
        """
        usual = sum(
            max(TRIANGLES_PER_AREA * part.polygon.area / self.size, part.polygon.length)
            for part in self.parts
        )
        return usual / self.size + self._further_triangles()

    def draw(self, gmsh: Any) -> list[DrawnPart]:
        """Draw the parts; see `bilayer.mesh.drawing.Drawing`."""
        geo = gmsh.model.geo
        points: dict[Vertex, int] = {}
        curves: dict[Chain, int] = {}
        sizes = self._sizes()
        for chain in self._chains:
            for vertex in chain:
                if vertex not in points:
                    points[vertex] = geo.addPoint(*vertex, 0, sizes[vertex])
            tags = [points[vertex] for vertex in chain]
            curves[chain] = geo.addLine(*tags) if len(tags) == 2 else geo.addPolyline(tags)
        surfaces = [geo.addPlaneSurface(self._loops(geo, part, curves)) for part in self.parts]
        centre, home = self._home_of_centre()
        at_centre = [] if home is None else [geo.addPoint(*centre, 0, self.size)]
        geo.synchronize()
        if home is not None:
            gmsh.model.mesh.embed(0, at_centre, 2, surfaces[home])
        if self.corner_size < self.size:
            self._refine(gmsh, points, curves)
        return [
            DrawnPart([surface], part.layers)
            for surface, part in zip(surfaces, self.parts, strict=True)
        ]

    @cached_property
    def _corners(self) -> frozenset[Vertex]:
        return corners_of(self.parts)

    @cached_property
    def _chains(self) -> dict[Chain, None]:
        """All chains, each once, in one of its two directions."""
        found: dict[Chain, None] = {}
        for part in self.parts:
            for ring in part.rings:
                for chain in chains_of(ring, self._corners):
                    if chain[::-1] not in found:
                        found[chain] = None
        return found

    def _sizes(self) -> dict[Vertex, float]:
        """Return the edge length at each point, shorter at a chain that bends within the usual."""
        sizes: dict[Vertex, float] = {}
        for chain in self._chains:
            turn = sum(_turn(*three) for three in zip(chain, chain[1:], chain[2:], strict=False))
            edges = max(1.0, turn / STRAIGHT)
            own = shapely.LineString(chain).length / edges if edges > 1 else self.size
            for vertex in chain:
                sizes[vertex] = min(self.size, own, sizes.get(vertex, self.size))
        return sizes

    @cached_property
    def _fine(self) -> tuple[list[Vertex], list[Chain]]:
        """Return the places of the corner size: the corners within the sheet, or else the cuts.

        The cuts are taken if none of them has a corner within the sheet.
        """
        rim = self.outline.boundary
        near = 10 * SNAP * math.sqrt(self.outline.area)
        within = [chain for chain in self._chains if rim.distance(_middle(chain)) > near]
        ends = dict.fromkeys(end for chain in within for end in (chain[0], chain[-1]))
        sharp = [
            end for end in ends if self._is_sharp(end) and rim.distance(shapely.Point(end)) > near
        ]
        return (sharp, []) if sharp else ([], within)

    def _is_sharp(self, vertex: Vertex) -> bool:
        """Whether the chains that meet at a point have a corner there."""
        ways = [chain[1] for chain in self._chains if chain[0] == vertex]
        ways += [chain[-2] for chain in self._chains if chain[-1] == vertex]
        return len(ways) != 2 or _turn(ways[0], vertex, ways[1]) > CORNER

    def _loops(self, geo: Any, part: Part, curves: dict[Chain, int]) -> list[int]:
        loops = []
        for ring in part.rings:
            chains = chains_of(ring, self._corners)
            tags = [curves[c] if c in curves else -curves[c[::-1]] for c in chains]
            loops.append(geo.addCurveLoop(tags))
        return loops

    def _home_of_centre(self) -> tuple[Vertex, int | None]:
        """Return the centre, and the part within which it lies, away from all edges."""
        point = shapely.Point(self.centre)
        for number, part in enumerate(self.parts):
            inside = part.polygon.contains(point)
            if inside and part.polygon.boundary.distance(point) > self.size / 3:
                return self.centre, number
        return self.centre, None

    def _refine(self, gmsh: Any, points: dict[Vertex, int], curves: dict[Chain, int]) -> None:
        """Let edges grow with the distance from the corners of the cuts."""
        corners, cuts = self._fine
        field = gmsh.model.mesh.field
        distance = field.add("Distance")
        field.setNumbers(distance, "PointsList", [points[corner] for corner in corners])
        field.setNumbers(distance, "CurvesList", [curves[chain] for chain in cuts])
        growth = field.add("Threshold")
        for name, value in (
            ("InField", distance),
            ("SizeMin", self.corner_size),
            ("SizeMax", self.size),
            ("DistMin", 0.0),
            ("DistMax", (self.size - self.corner_size) / GRADING),
        ):
            field.setNumber(growth, name, value)
        field.setAsBackgroundMesh(growth)

    def _further_triangles(self) -> float:
        """Return the number of triangles that the corner size adds.

        The edge length h = c + g r at the distance r, up to h = s: TRIANGLES_PER_AREA times the
        integral of 1/h^2 - 1/s^2 over the area, around points and beside lines.
        """
        s, c, g = self.size, self.corner_size, GRADING
        if c == s:
            return 0.0
        corners, cuts = self._fine
        reach = (s - c) / g
        around = 2 * math.pi * ((math.log(s / c) + c / s - 1) / g**2 - (reach / s) ** 2 / 2)
        beside = 2 * ((1 / c - 1 / s) / g - reach / s**2)
        length = sum(shapely.LineString(chain).length for chain in cuts)
        return TRIANGLES_PER_AREA * (len(corners) * around + length * beside)


def divided(specimen: Specimen) -> tuple[Part, ...]:
    """Return the parts of a specimen's sheet on which the same layers lie."""
    grid = SNAP * specimen.characteristic_length
    patterned = [layer.name for layer in specimen.layers if not layer.is_whole]
    whole = frozenset(layer.name for layer in specimen.layers if layer.is_whole)
    regions = {name: specimen.region_of(name) for name in patterned}
    outline = specimen.outline.polygon
    edges = [outline.boundary, *(region.boundary for region in regions.values())]
    edges += specimen.drawn_lines
    lines = shapely.union_all(edges, grid_size=grid)
    parts = []
    for polygon in shapely.polygonize([lines]).geoms:
        inside = polygon.representative_point()
        if outline.contains(inside):
            there = [name for name, region in regions.items() if region.contains(inside)]
            parts.append(Part(polygon, whole | frozenset(there)))
    laid = [part for part in parts if part.layers]
    return without_misfits(laid, specimen.mesh.corner_size or specimen.mesh.size)


def without_misfits(parts: list[Part], size: float) -> tuple[Part, ...]:
    """Return the parts with each misfit given to the part beside it that has the longer edge.

    A misfit is what lies between two edges that nearly coincide, as two patterns have them if they
    come from different drawings. A narrow part with the same layers on both sides is a slit, and
    stays.

    Parameters
    ----------
    parts : list of Part
        On which layers lie.
    size : float
        Edge length of the mesh there, m.
    """
    wide = [part for part in parts if part.width >= MISFIT * size]
    slits = []
    for narrow in (part for part in parts if part.width < MISFIT * size):
        shared = [narrow.polygon.intersection(part.polygon).length for part in wide]
        beside = [number for number in np.argsort(shared)[::-1][:2] if shared[number] > 0]
        if len({wide[number].layers for number in beside} - {narrow.layers}) == 2:
            other = wide[beside[0]]
            wide[beside[0]] = Part(narrow.polygon.union(other.polygon), other.layers)
        else:
            slits.append(narrow)
    return (*wide, *slits)


def corners_of(parts: tuple[Part, ...]) -> frozenset[Vertex]:
    """Return the points at which chains end.

    Where other than two edges meet, or two at an angle; and of a ring without such a point its
    outermost ones along x, so that no chain is closed.
    """
    rings = [ring for part in parts for ring in part.rings]
    neighbours: dict[Vertex, set[Vertex]] = {}
    for ring in rings:
        for a, b in pairwise([*ring, ring[0]]):
            neighbours.setdefault(a, set()).add(b)
            neighbours.setdefault(b, set()).add(a)
    corners = {
        vertex
        for vertex, around in neighbours.items()
        if len(around) != 2 or _turn(*_between(around, vertex)) > CORNER
    }
    for ring in rings:
        if len(corners.intersection(ring)) < 2:
            corners |= {min(ring), max(ring)}
    return frozenset(corners)


def chains_of(ring: list[Vertex], corners: frozenset[Vertex]) -> list[Chain]:
    """Return a ring as chains from corner to corner, in its direction."""
    start = next(k for k, vertex in enumerate(ring) if vertex in corners)
    turned = [*ring[start:], *ring[:start], ring[start]]
    ends = [k for k, vertex in enumerate(turned) if vertex in corners]
    return [tuple(turned[a : b + 1]) for a, b in pairwise(ends)]


def _between(around: set[Vertex], vertex: Vertex) -> tuple[Vertex, Vertex, Vertex]:
    one, other = sorted(around)
    return one, vertex, other


def _turn(before: Vertex, at: Vertex, after: Vertex) -> float:
    """Return by what angle a line turns at a point, rad, from 0 to pi."""
    u, v = np.subtract(at, before), np.subtract(after, at)
    return abs(math.atan2(u[0] * v[1] - u[1] * v[0], float(u @ v)))


def _middle(chain: Chain) -> shapely.Point:
    line = shapely.LineString(chain)
    return line.interpolate(0.5, normalized=True)
