"""Whether a planar mesh is one of a specimen: its outline, and the layers on every triangle.

The rim of a mesh is a polygon whose corners lie on the outline, so all that is not a corner may lie
beside it by a share of the edges' length.
"""

import numpy as np
import shapely
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.mesh.planar import PlanarMesh
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
    _check_outline(specimen, mesh)
    for name in specimen.layer_names:
        if not _mesh_defines(specimen, name):
            _check_layer(specimen, mesh, name)


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
    edges = mesh.points[mesh.boundary_edges]
    edge = float(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).mean())
    near = ON_OUTLINE * specimen.characteristic_length
    outline = specimen.sheet.boundary
    rim = shapely.multilinestrings([shapely.linestrings(edges)])[0]
    nodes = mesh.points[np.unique(mesh.boundary_edges)]
    apart = shapely.distance(shapely.points(nodes), outline)
    missed = shapely.distance(shapely.points(shapely.get_coordinates(outline)), rim)
    farthest = int(np.argmax(apart))
    if np.mean(apart <= near) < SHARE_ON_OUTLINE or apart[farthest] > near + RIM_BESIDE * edge:
        x, y = nodes[farthest]
        raise InputError(
            f"mesh: the node of its rim at ({x:g}, {y:g}) m lies {apart[farthest]:.3g} m from the "
            f"specimen's outline, expected {specimen.length_text}"
        )
    if missed.max() > near + OUTLINE_BESIDE * edge:
        x, y = shapely.get_coordinates(outline)[np.argmax(missed)]
        raise InputError(
            f"mesh: its rim passes the specimen's outline at ({x:g}, {y:g}) m by "
            f"{missed.max():.3g} m, expected {specimen.length_text}"
        )


def _check_layer(specimen: Specimen, mesh: PlanarMesh, name: str) -> None:
    region = specimen.region_of(name)
    x, y = mesh.points[mesh.triangles].mean(axis=1).T
    covered = np.zeros(len(x), dtype=bool)
    covered[mesh.faces_of(name)] = True
    shapely.prepare(region)
    differ = np.flatnonzero(shapely.contains_xy(region, x, y) != covered)
    beside = shapely.distance(shapely.points(x[differ], y[differ]), region.boundary)
    wrong = differ[beside > CENTROID_BESIDE * np.sqrt(mesh.areas[differ])]
    if len(wrong):
        first = wrong[0]
        found, expected = ("lies", "does not lie") if covered[first] else ("is missing", "lies")
        share = mesh.areas[wrong].sum() / mesh.areas.sum()
        raise InputError(
            f"mesh: the layer {name!r} {found} on triangle {first} at ({x[first]:g}, {y[first]:g}) "
            f"m, where the specimen's {expected} ({share:.1%} of the area is wrong); a mesh with a "
            "pattern of its own goes with two whole layers"
        )
