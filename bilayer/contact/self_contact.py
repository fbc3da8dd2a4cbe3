"""The self-contact gap of a released body, from the skin of its layers.

The skin is the closed surface of the body. It consists of the sides of the layers on which no other
layer lies, and of walls at the rim and along the cuts. Two places of the skin can touch only if the
sheet is bent back onto itself. This is measured on the reference surface, so that a tight curl
whose inner side is short does not count as contact. docs/measures.md has the definition.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.contact.bent_back import Balls, Places, bent_back_pairs
from bilayer.contact.triangle_distance import triangle_distance
from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH = 1.0
"""Gaps are measured up to this many bonded thicknesses of all layers together."""
TOUCHING = 1e-6
"""Skins nearer than this share of that thickness touch: above round-off, below every error."""
MIDDLE_ROUNDS = 3
"""Rounds of the fixed point for the height of a layer, the first from the area of its base."""
BATCH = 4096
"""Pairs of triangles that are measured at once."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A layer as the skin knows it.

    Parameters
    ----------
    bottom, top : float
        Heights over the reference surface in the flat bonded state, m.
    faces : (k,) array of int
        Triangles that it covers.
    """

    bottom: float
    top: float
    faces: Indices


@dataclass(frozen=True, eq=False)
class BondedBody:
    """A flat sheet of layers as a solid.

    Parameters
    ----------
    mesh : PlanarMesh
        The reference surface.
    sheets : sequence of Sheet
        The layers from the bottom up, each on the one before; the reference surface lies in one of
        them or between two.
    shrinkage : float
        Length that a stretched layer would take if it were free over its bonded length: the
        largest shortening of the reference surface that is no bending back.
    """

    mesh: PlanarMesh
    sheets: Sequence[Sheet]
    shrinkage: float = 1.0

    @classmethod
    def of(cls, specimen: Specimen, mesh: PlanarMesh, stretch: tuple[float, float]) -> "BondedBody":
        """Return the body that a specimen is when bonded at a prestretch."""
        sheets = [
            Sheet(part.bottom, part.top, mesh.faces_of(part.name))
            for part in specimen.bonded_layers(stretch)
        ]
        longest = max(max(layer.response.axial(stretch)) for layer in specimen.layers)
        return cls(mesh, sheets, shrinkage=1 / max(1.0, longest))

    @property
    def thickness(self) -> float:
        """Of all layers together, m."""
        return sum(sheet.top - sheet.bottom for sheet in self.sheets)

    @property
    def reach(self) -> float:
        """Up to where a gap is measured, m."""
        return REACH * self.thickness


@dataclass(frozen=True, eq=False)
class Skin:
    """The closed surface of a body; `face` is the mesh's triangle that each of its own covers."""

    surface: Surface
    face: Indices


def self_contact_gap(body: BondedBody, position: Array) -> float:
    """Return the smallest distance between two places of the skin that are bent back, m.

    Parameters
    ----------
    body : BondedBody
        The flat state.
    position : (n, 3) array of float
        The reference surface on the nodes of its mesh, m.

    Returns
    -------
    float
        0 if the body touches or crosses itself; infinity if no two places that are bent back
        onto each other come nearer than `body.reach`.
    """
    reference = Surface(np.asarray(position, dtype=np.float64), body.mesh.triangles)
    skin = skin_of(body, reference)
    pairs = _bent_back_pairs(body, reference, skin)
    touching = TOUCHING * body.thickness
    nearest = _smallest_distance(skin.surface.corners, pairs, touching, body.reach)
    return 0.0 if nearest <= touching else nearest


def skin_of(body: BondedBody, reference: Surface) -> Skin:
    """Return the skin of a released body, its triangles turned outward.

    Parameters
    ----------
    body : BondedBody
        The flat state.
    reference : Surface
        The released reference surface.
    """
    mesh, n = body.mesh, len(reference.points)
    surfaces, sides = _sides_of(body, reference)
    nothing = np.empty(0, dtype=np.int64)
    faces = [nothing, *(sheet.faces for sheet in body.sheets), nothing]
    parts = []
    for number, (below, own, above) in enumerate(zip(faces, faces[1:], faces[2:], strict=False)):
        lower, upper = (n * side for side in sides[number])
        bottom, top = np.setdiff1d(own, below), np.setdiff1d(own, above)
        parts += [
            (mesh.triangles[bottom][:, ::-1] + lower, bottom),
            (mesh.triangles[top] + upper, top),
            _walls(mesh, own, lower, upper),
        ]
    triangles, face = (np.concatenate(part) for part in zip(*parts, strict=True))
    return Skin(Surface(np.concatenate(surfaces), triangles), face)


def _sides_of(body: BondedBody, reference: Surface) -> tuple[list[Array], list[tuple[int, int]]]:
    """Return the sides of the layers as surfaces, (n, 3) each, and the numbers of each layer's two.

    Surface 0 is the reference; from there the layers follow each other, each on the one before.
    """
    surfaces = [reference.points]
    lower, upper = [0] * len(body.sheets), [0] * len(body.sheets)

    def add(base: int, sheet: Sheet, height: float) -> int:
        fibres = _fibres(body.mesh, surfaces[base], sheet.faces, height)
        surfaces.append(surfaces[base] + fibres)
        return len(surfaces) - 1

    base = 0
    for number, sheet in reversed([*enumerate(body.sheets)]):
        if sheet.bottom < 0:
            upper[number] = base
            base = lower[number] = add(base, sheet, sheet.bottom - min(sheet.top, 0.0))
    base = 0
    for number, sheet in enumerate(body.sheets):
        if sheet.top > 0:
            lower[number] = lower[number] or base
            base = upper[number] = add(base, sheet, sheet.top - max(sheet.bottom, 0.0))
    return surfaces, list(zip(lower, upper, strict=True))


def _fibres(mesh: PlanarMesh, base: Array, faces: Indices, height: float) -> Array:
    """Return the fibres of a layer from its base to its other side, m, (n, 3).

    Straight, along the area-weighted normals of the layer's own triangles, so that a bare wedge
    that is folded does not tilt the kirigami beside it; at nodes without the layer those of all
    triangles, for what lies on it. The layer keeps its volume: it is as high as it was over the
    area stretch of its own middle surface.
    """
    own, covered = _fibres_of(mesh, base, faces, height)
    if covered.all():
        return own
    everywhere, _ = _fibres_of(mesh, base, np.arange(len(mesh.triangles)), height)
    return np.where(covered[:, None], own, everywhere)


def _fibres_of(
    mesh: PlanarMesh, base: Array, faces: Indices, height: float
) -> tuple[Array, NDArray[np.bool_]]:
    """Return the fibres at the nodes of some triangles, zero elsewhere, and which these are."""
    triangles = mesh.triangles[faces]
    layer = Surface(base, triangles)
    thirds, corners = np.repeat(layer.area_vectors / 3, 3, axis=0), triangles.ravel()
    n = len(base)
    sums = np.column_stack([np.bincount(corners, part, minlength=n) for part in thirds.T])
    covered = layer.node_areas > 0
    normals = sums / np.where(covered, np.linalg.norm(sums, axis=1), 1)[:, None]
    flat = Surface(flat_surface(mesh).points, triangles).node_areas
    fibres = np.zeros_like(normals)
    for _ in range(MIDDLE_ROUNDS):
        middle = Surface(base + fibres / 2, triangles).node_areas
        stretch = np.divide(middle, flat, out=np.ones_like(flat), where=covered)
        fibres = height / stretch[:, None] * normals
    return fibres, covered


def _walls(mesh: PlanarMesh, faces: Indices, lower: int, upper: int) -> tuple[Indices, Indices]:
    """Return the walls around some triangles between two sheets, and the triangle of each."""
    corners = mesh.triangles[faces]
    edges = np.stack([corners, np.roll(corners, -1, axis=1)], axis=2).reshape(-1, 2)
    _, place, count = np.unique(np.sort(edges), axis=0, return_inverse=True, return_counts=True)
    outline = count[place.ravel()] == 1
    a, b = edges[outline].T
    walls = [[a + lower, b + lower, b + upper], [a + lower, b + upper, a + upper]]
    return np.concatenate([np.stack(wall, axis=1) for wall in walls]), np.tile(
        np.repeat(faces, 3)[outline], 2
    )


def _bent_back_pairs(body: BondedBody, reference: Surface, skin: Skin) -> Indices:
    """Return pairs of the skin's triangles that are bent back, (k, 2), the nearest among them."""
    flat = flat_surface(body.mesh)
    natural, chord = (s.corners.mean(axis=1)[skin.face] for s in (flat, reference))
    corners, points = skin.surface.corners, np.zeros(len(skin.face))
    places = Places(
        Balls(body.shrinkage * natural, points),
        Balls(chord, points),
        Balls(corners.mean(axis=1), _radii(corners)),
    )
    bonded = skin_of(body, flat).surface.corners.mean(axis=1)
    return bent_back_pairs(places, bonded, body.mesh.triangles[skin.face], body.reach)


def _apart(points: Array, one: Indices, other: Indices) -> Array:
    """Return the distance of each two points, m."""
    between = points[one] - points[other]
    return np.sqrt(np.einsum("ij,ij->i", between, between))


def _smallest_distance(corners: Array, pairs: Indices, touching: float, reach: float) -> float:
    """Return the smallest distance of the pairs of triangles; infinity beyond the reach.

    Nearest first by their circles, until no other pair can be nearer than the best, or two touch.
    """
    centres, radii = corners.mean(axis=1), _radii(corners)
    one, other = pairs.T
    at_least = _apart(centres, one, other) - radii[one] - radii[other]
    order = np.argsort(at_least)
    best = float(np.inf)
    for start in range(0, len(order), BATCH):
        batch = order[start : start + BATCH]
        if best <= touching or at_least[batch[0]] > min(best, reach):
            break
        found = triangle_distance(corners[one[batch]], corners[other[batch]]).min()
        best = min(best, float(found))
    return best if best <= reach else float(np.inf)


def _radii(corners: Array) -> Array:
    """Return the distance of each triangle's farthest corner from its centre, m."""
    return np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
