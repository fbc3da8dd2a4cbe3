"""What of a part cannot be made: narrow webs and slots, loose pieces, corners within the kerf."""

from dataclasses import dataclass

import shapely

from bilayer.drawings.contours import place
from bilayer.specimen.outline import pieces_of

SHARE = 1e-3
"""Narrower by this share than asked for counts: a web of just the least width does not."""
SLIVER = 0.02
"""Reaching less far than this share of the width counts as nothing: blunt corners."""
ARC = 32
"""Lines for a quarter of a turn: an arc is nearer to them than `SHARE` of its radius."""
FULL = 0.7
"""Part of its rectangle that a tongue fills; a triangle, half of it."""


@dataclass(frozen=True)
class Obstacle:
    """A place at which a part cannot be made as it is.

    Parameters
    ----------
    what : str
        In words, lengths in mm.
    point : (float, float)
        Where, m.
    """

    what: str
    point: tuple[float, float]

    def __str__(self) -> str:
        return f"{self.what} at {place(self.point)}"


def obstacles(region: shapely.Geometry, least_web: float, kerf: float) -> list[Obstacle]:
    """Return what of a part cannot be made.

    Parameters
    ----------
    region : Polygon or MultiPolygon
        The part, m.
    least_web : float
        Webs and slots that are narrower cannot be made, m.
    kerf : float
        Width of the cut, m.

    Returns
    -------
    list of Obstacle
        Loose pieces, webs, slots, inner corners that stay rounded.

    Examples
    --------
    >>> import shapely
    >>> dumbbell = shapely.union_all(
    ...     [shapely.box(0, 0, 0.02, 0.02), shapely.box(0.02, 0.01, 0.03, 0.0105),
    ...      shapely.box(0.03, 0, 0.05, 0.02)]
    ... )
    >>> print(*obstacles(dumbbell, least_web=0.001, kerf=0))
    web of 0.5 mm at (25, 10.25) mm
    """
    found = [*_loose(region), *_narrow(region, least_web, "web")]
    slot = max(least_web, kerf)
    around = shapely.box(*region.bounds).buffer(4 * slot, join_style="mitre")
    found += _narrow(shapely.difference(around, region), slot, "slot")
    return found + _rounded(region, kerf)


def _loose(region: shapely.Geometry) -> list[Obstacle]:
    pieces = sorted(pieces_of(region), key=lambda piece: -piece.area)
    return [
        Obstacle(f"loose piece of {1e6 * piece.area:.3g} mm2", _point_in(piece))
        for piece in pieces[1:]
    ]


def _narrow(region: shapely.Geometry, width: float, what: str) -> list[Obstacle]:
    """Return the places at which a region is narrower than a width, its corners left out.

    A disc of that width does not reach them. A corner also has such a place, which tapers and is
    joined to the rest at one side; a web is joined to it at two, a tongue hardly tapers.
    """
    radius = (1 - SHARE) * width / 2
    wide = region.buffer(-radius, quad_segs=ARC)
    reached = wide.buffer(radius * (1 + SHARE), quad_segs=ARC)
    places = []
    for rest in pieces_of(shapely.difference(region, reached)):
        rim = shapely.segmentize(rest.exterior, width / 8)
        depth = shapely.distance(shapely.points(rim.coords), reached).max()
        if depth < SLIVER * width:
            continue
        circle = shapely.maximum_inscribed_circle(rest, tolerance=1e-3 * width)
        middle = shapely.Point(circle.coords[0])
        breadth = 2 * region.boundary.distance(middle)
        contacts = pieces_of(shapely.intersection(reached, rest.buffer(SHARE * width)))
        tapers = rest.area < FULL * breadth * rest.length / 2
        if breadth < width * (1 - SHARE) and not (tapers and len(contacts) == 1):
            places.append(middle)
    places += [
        neck
        for neck in _necks(region, wide)
        if all(neck.distance(place) > width for place in places)
    ]
    breadths = [2 * region.boundary.distance(place) for place in places]
    return [
        Obstacle(f"{what} of {1e3 * breadth:.2g} mm", (place.x, place.y))
        for place, breadth in zip(places, breadths, strict=True)
    ]


def _necks(region: shapely.Geometry, wide: shapely.Geometry) -> list[shapely.Point]:
    """Return the places at which a piece of a region falls apart into its wide parts."""
    necks = []
    for piece in pieces_of(region):
        parts = [part for part in pieces_of(wide) if piece.contains(part.representative_point())]
        for part in sorted(parts, key=lambda part: part.area)[:-1]:
            others = shapely.union_all([other for other in parts if other is not part])
            bridge = shapely.shortest_line(part, others)
            necks.append(bridge.interpolate(0.5, normalized=True))
    return necks


def _rounded(region: shapely.Geometry, kerf: float) -> list[Obstacle]:
    """Return the inner corners that a beam of the kerf's width leaves round."""
    if kerf == 0:
        return []
    radius = kerf / 2
    grown = region.buffer(radius, quad_segs=ARC).buffer(-radius, quad_segs=ARC)
    rests = [
        rest
        for rest in pieces_of(shapely.difference(grown, region))
        if rest.area > 1e-2 * radius**2  # of a right angle it is 0.21
    ]
    if not rests:
        return []
    number = f"{len(rests)} inner corners stay" if len(rests) > 1 else "an inner corner stays"
    text = f"{number} rounded to the kerf's radius of {1e3 * radius:g} mm, the first"
    return [Obstacle(text, _point_in(rests[0]))]


def _point_in(piece: shapely.Geometry) -> tuple[float, float]:
    point = piece.representative_point()
    return point.x, point.y
