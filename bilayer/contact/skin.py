"""The skin of a released body: its closed surface, from the reference surface and the layers.

The skin consists of the sides of the layers on which no other layer lies, and of walls at the rim
and along the cuts.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.surface import Surface
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH = 1.0
"""Gaps are measured up to this many bonded thicknesses of all layers together."""
MIDDLE_ROUNDS = 3
"""Rounds of the fixed point for the height of a layer, the first from the area of its base."""


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


@dataclass(frozen=True, eq=False)
class Side:
    """A side of a layer as a surface on the nodes of the mesh.

    Parameters
    ----------
    base : int
        The side on which the layer lies, among the sides of the body; 0 is the reference surface.
    faces : (k,) array of int
        Triangles of the layer.
    rise : float
        Flat height over the base, m.
    height : float
        Flat height over the reference surface, m.
    """

    base: int
    faces: Indices
    rise: float
    height: float


def skin_of(body: BondedBody, reference: Surface) -> Skin:
    """Return the skin of a released body, its triangles turned outward.

    Parameters
    ----------
    body : BondedBody
        The flat state.
    reference : Surface
        The released reference surface.
    """
    triangles, face = skin_triangles(body)
    return Skin(Surface(np.concatenate(side_points(body, reference)), triangles), face)


def side_points(body: BondedBody, reference: Surface) -> list[Array]:
    """Return the nodes on the reference surface and on each of `sides_of`, m, (n, 3) each."""
    surfaces = [reference.points]
    for side in sides_of(body)[0]:
        base = surfaces[side.base]
        surfaces.append(base + _fibres(body.mesh, base, side.faces, side.rise))
    return surfaces


def skin_triangles(body: BondedBody) -> tuple[Indices, Indices]:
    """Return the triangles of the skin, and the mesh's triangle that each of them covers.

    Node i on side s has the number i + s times the number of nodes; see `sides_of`.
    """
    mesh, n = body.mesh, len(body.mesh.points)
    _, sides = sides_of(body)
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
    return triangles, face


def sides_of(body: BondedBody) -> tuple[list[Side], list[tuple[int, int]]]:
    """Return the sides of the layers, and the numbers of the lower and the upper one of each.

    Number 0 is the reference surface. The side of number k is at place k - 1 of the list. From the
    reference the layers follow each other, each on the one before.
    """
    sides: list[Side] = []
    lower, upper = [0] * len(body.sheets), [0] * len(body.sheets)

    def add(base: int, sheet: Sheet, rise: float, height: float) -> int:
        sides.append(Side(base, sheet.faces, rise, height))
        return len(sides)

    base = 0
    for number, sheet in reversed([*enumerate(body.sheets)]):
        if sheet.bottom < 0:
            upper[number] = base
            rise = sheet.bottom - min(sheet.top, 0.0)
            base = lower[number] = add(base, sheet, rise, sheet.bottom)
    base = 0
    for number, sheet in enumerate(body.sheets):
        if sheet.top > 0:
            lower[number] = lower[number] or base
            base = upper[number] = add(base, sheet, sheet.top - max(sheet.bottom, 0.0), sheet.top)
    return sides, list(zip(lower, upper, strict=True))


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
