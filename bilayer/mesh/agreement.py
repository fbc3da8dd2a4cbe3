"""Whether a planar mesh is one of a specimen: its outline, and the layers on every triangle.

The rim of a mesh is a polygon whose corners lie on the outline, so all that is not a corner may lie
beside it by a share of the edges' length. The corners of the outline are nodes. The same holds for
the edges of each layer that has a pattern.
"""

from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.divided_sheet import CORNER, SNAP
from bilayer.mesh.planar import PlanarMesh
from bilayer.mesh.validity import check_covers_once
from bilayer.specimen.specimen import Specimen

ON_OUTLINE = 1e-3
"""Nodes nearer than this share of the characteristic length lie on the outline."""
SHARE_ON_OUTLINE = 1 / 3
"""At least so many of the rim's nodes do."""
RIM_BESIDE, OUTLINE_BESIDE = 0.3, 0.6
"""The others, and the outline's own points, lie at most so many rim edges from each other."""
CENTROID_BESIDE = 0.3
"""Centroids nearer to a pattern's edge, over the root of the triangle's area, do not count."""

Array = NDArray[np.float64]


def check_agreement(specimen: Specimen, mesh: PlanarMesh) -> None:
    """Raise InputError unless a mesh is one of a specimen.

    A bilayer of two whole layers takes a mesh with a pattern of its own: the mesh defines it.
    """
    _check_names(specimen, mesh)
    check_covers_once(mesh.points, mesh.triangles)
    _check_outline(specimen, mesh)
    for name in specimen.layer_names:
        if len(mesh.faces_of(name)) == 0:
            raise InputError(f"mesh: the layer {name!r} lies on none of its triangles")
        if not _mesh_defines(specimen, name):
            _check_layer(specimen, mesh, name)


def layers_defined_by(mesh: PlanarMesh, specimen: Specimen) -> dict[str, float]:
    """Return the layers whose pattern is the mesh's and not the specimen's.

    Parameters
    ----------
    mesh : PlanarMesh
        A mesh of the specimen.
    specimen : Specimen
        Of two whole layers, or else no layer is.

    Returns
    -------
    dict of str to float
        For each such layer the share of the sheet that it covers, less than 1.
    """
    areas = mesh.areas
    return {
        name: float(areas[mesh.faces_of(name)].sum() / areas.sum())
        for name in specimen.layer_names
        if _mesh_defines(specimen, name) and len(mesh.faces_of(name)) < len(areas)
    }


def _mesh_defines(specimen: Specimen, name: str) -> bool:
    all_whole = all(layer.is_whole for layer in specimen.layers)
    return len(specimen.layers) == 2 and all_whole and name != specimen.carrier.name


def _check_names(specimen: Specimen, mesh: PlanarMesh) -> None:
    used = frozenset().union(*(mesh.layer_sets[number] for number in np.unique(mesh.region)))
    unknown = sorted(used - set(specimen.layer_names))
    if unknown:
        raise InputError(
            f"mesh: has the layer {unknown[0]!r}, expected those of the specimen: "
            f"{', '.join(specimen.layer_names)}"
        )


def _check_outline(specimen: Specimen, mesh: PlanarMesh) -> None:
    expected = f"expected {specimen.length_text}"
    sheet = specimen.sheet.boundary
    _check_edges(specimen, mesh, mesh.boundary_edges, sheet, "its rim", "outline", expected)


def _check_edges(
    specimen: Specimen,
    mesh: PlanarMesh,
    pairs: NDArray[np.int64],
    line: shapely.Geometry,
    found: str,
    wanted: str,
    expected: str,
) -> None:
    """Raise InputError unless the edges of some node pairs are those of a line of the specimen."""
    edges = mesh.points[pairs]
    edge = float(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).mean())
    near = ON_OUTLINE * specimen.characteristic_length
    nodes = mesh.points[np.unique(pairs)]
    apart = shapely.distance(shapely.points(nodes), line)
    farthest = int(np.argmax(apart))
    if np.mean(apart <= near) < SHARE_ON_OUTLINE or apart[farthest] > near + RIM_BESIDE * edge:
        x, y = nodes[farthest]
        raise InputError(
            f"mesh: the node of {found} at ({x:g}, {y:g}) m lies {apart[farthest]:.3g} m from the "
            f"specimen's {wanted}, {expected}"
        )
    rim = shapely.multilinestrings([shapely.linestrings(edges)])[0]
    missed = shapely.distance(shapely.points(shapely.get_coordinates(line)), rim)
    if missed.max() > near + OUTLINE_BESIDE * edge:
        x, y = shapely.get_coordinates(line)[np.argmax(missed)]
        raise InputError(
            f"mesh: {found} passes the specimen's {wanted} at ({x:g}, {y:g}) m by "
            f"{missed.max():.3g} m, {expected}"
        )
    corners = _corners(line, SNAP * specimen.characteristic_length)
    if len(corners):
        tree = shapely.STRtree(shapely.points(nodes))
        _, beside = tree.query_nearest(corners, return_distance=True, all_matches=False)
        if beside.max() > near:
            x, y = shapely.get_coordinates(corners[np.argmax(beside)])[0]
            raise InputError(
                f"mesh: {found} has no node at the corner ({x:g}, {y:g}) m of the specimen's "
                f"{wanted}, the nearest lies {beside.max():.3g} m from it, {expected}"
            )


def _corners(line: shapely.Geometry, least: float) -> NDArray[Any]:
    """Return the points at which the rings of a line turn by more than a mesh leaves out."""
    corners = []
    for ring in shapely.get_parts(shapely.simplify(line, least)):
        points = shapely.get_coordinates(ring)[:-1]  # the last is the first
        after = np.roll(points, -1, axis=0) - points
        before = np.roll(after, 1, axis=0)
        cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        turn = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
        corners.append(shapely.points(points[turn > CORNER]))
    return np.concatenate(corners)


def _check_layer(specimen: Specimen, mesh: PlanarMesh, name: str) -> None:
    region = specimen.region_of(name)
    x, y = mesh.points[mesh.triangles].mean(axis=1).T
    covered = np.zeros(len(x), dtype=bool)
    covered[mesh.faces_of(name)] = True
    shapely.prepare(region)
    differ = np.flatnonzero(shapely.contains_xy(region, x, y) != covered)
    beside = shapely.distance(shapely.points(x[differ], y[differ]), region.boundary)
    wrong = differ[beside > CENTROID_BESIDE * np.sqrt(mesh.areas[differ])]
    elsewhere = "a mesh with a pattern of its own goes with two whole layers"
    if len(wrong):
        first = wrong[0]
        found, expected = ("lies", "does not lie") if covered[first] else ("is missing", "lies")
        share = mesh.areas[wrong].sum() / mesh.areas.sum()
        raise InputError(
            f"mesh: the layer {name!r} {found} on triangle {first} at ({x[first]:g}, {y[first]:g}) "
            f"m, where the specimen's {expected} ({share:.1%} of the area is wrong); {elsewhere}"
        )
    if not specimen.layer(name).is_whole:
        of = f"the edge of the layer {name!r}"
        pairs = mesh.edges_of(np.flatnonzero(covered))
        _check_edges(specimen, mesh, pairs, region.boundary, of, "pattern", elsewhere)
