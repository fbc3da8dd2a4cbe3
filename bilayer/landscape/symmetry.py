"""The motions of the plane that leave a specimen as it is, and a shape's images under them.

A shape is a map x(X) from the flat sheet to space. Turning or mirroring the sheet in its plane by g
takes it to g x(g^-1 X), which has the same energy. Between nodes x is linear.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
import shapely
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from bilayer.geometry.alignment import align, rms_distance
from bilayer.mesh.planar import PlanarMesh, flat_surface
from bilayer.specimen.outline import Symmetry
from bilayer.specimen.prestretch import StretchPair
from bilayer.specimen.specimen import Specimen

Array = NDArray[np.float64]

MOST_TURNS = 24
"""Of a drawn region, that are looked for."""
SAME_AREA = 1e-3
"""Share of its area by which a drawn region may differ from its image."""
TURNS_OF_A_CIRCLE = 72
"""Turns that stand for all, if any turn leaves the specimen as it is."""
TURN_TOLERANCE = 1e-3
"""Of the turn at which two shapes are nearest, rad."""
NEAR_TRIANGLES = 8


def symmetry_of(specimen: Specimen, stretch: StretchPair) -> Symmetry:
    """Return the symmetry of a specimen whose prestretch is given.

    The built-in outlines and patterns know theirs; of what is drawn, it is looked for.

    Examples
    --------
    >>> import bilayer
    >>> symmetry_of(bilayer.paper_specimen(), (1.1, 1.1))
    Symmetry(turns=5, mirrored=True)
    >>> symmetry_of(bilayer.paper_specimen(), (1.1, 1.05))
    Symmetry(turns=1, mirrored=True)
    """
    common = _symmetry_of(specimen.outline.symmetry, specimen.outline.polygon)
    for layer in specimen.layers:
        if layer.pattern is not None:
            region = layer.pattern.kept(specimen.outline)
            common = common.common(_symmetry_of(layer.pattern.symmetry, region))
        first, second = layer.response.axial(stretch)
        if first != second:
            common = common.common(Symmetry(2, layer.response.is_along_axes))
    return common


def _symmetry_of(known: Symmetry, region: shapely.Geometry) -> Symmetry:
    """Return the symmetry of a region, looked for if it is said to have none."""
    if known != Symmetry(1, False):
        return known
    turns = range(MOST_TURNS, 1, -1)
    most = next((n for n in turns if _is_same(region, _turn_of(2 * math.pi / n))), 1)
    return Symmetry(most, _is_same(region, MIRROR))


def _is_same(region: shapely.Geometry, motion: Array) -> bool:
    image = shapely.transform(region, lambda points: points @ motion.T)
    return bool(region.symmetric_difference(image).area <= SAME_AREA * region.area)


def _turn_of(angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


MIRROR = np.diag([1.0, -1.0])


@dataclass(frozen=True)
class Motion:
    """A motion of the plane that leaves the specimen as it is.

    Parameters
    ----------
    turn : float
        Angle of the turn, after the mirroring, rad.
    mirrors : bool
        Whether the x axis is a mirror.
    """

    turn: float
    mirrors: bool

    @property
    def matrix(self) -> Array:
        """It as a matrix, (2, 2)."""
        return _turn_of(self.turn) @ (MIRROR if self.mirrors else np.eye(2))


class Images:
    """The images of shapes on a mesh under the symmetry of the specimen.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the flat sheet.
    symmetry : Symmetry
        Of the specimen.
    """

    def __init__(self, mesh: PlanarMesh, symmetry: Symmetry) -> None:
        self.mesh, self.symmetry = mesh, symmetry
        self._weights = flat_surface(mesh).node_areas

    @cached_property
    def motions(self) -> list[Motion]:
        """The motions of the group, the identity first; some of them if all turns are in it."""
        count = self.symmetry.turns or TURNS_OF_A_CIRCLE
        mirrors = (False, True) if self.symmetry.mirrored else (False,)
        turns = 2 * math.pi * np.arange(count) / count
        return [Motion(float(turn), mirrored) for mirrored in mirrors for turn in turns]

    def of(self, shape: Array) -> Iterator[Array]:
        """Yield the images of a shape, (n, 3), m, itself first."""
        for motion, values_at in zip(self.motions, self._interpolations, strict=True):
            yield _moved(values_at @ shape, motion)

    def plain_distance(self, first: Array, second: Array) -> float:
        """Return the rms distance of two shapes, not of images, after rigid alignment, m."""
        return rms_distance(second, first, self._weights)

    def distance(self, first: Array, second: Array) -> float:
        """Return the least rms distance of a shape from the images of another, m."""
        distances = [self.plain_distance(first, image) for image in self.of(second)]
        nearest = int(np.argmin(distances))
        if self.symmetry.turns:
            return distances[nearest]
        return self._distance_near(self.motions[nearest], first, second)

    def _distance_near(self, motion: Motion, first: Array, second: Array) -> float:
        """Return the least distance over the turns near one, of a sheet that any turn leaves."""

        def distance(turn: float) -> float:
            near = replace(motion, turn=turn)
            values = interpolation(self.mesh, self.mesh.points @ near.matrix) @ second
            return self.plain_distance(first, _moved(values, near))

        step = 2 * math.pi / TURNS_OF_A_CIRCLE
        bounds = motion.turn - step, motion.turn + step
        found = scipy.optimize.minimize_scalar(
            distance, bounds=bounds, method="bounded", options={"xatol": TURN_TOLERANCE}
        )
        return float(found.fun)

    def nearest(self, shape: Array, other: Array) -> Array:
        """Return the image of `other` nearest to a shape, moved onto it, (n, 3), m."""
        images = list(self.of(other))
        distances = [rms_distance(image, shape, self._weights) for image in images]
        return align(images[int(np.argmin(distances))], shape, self._weights)

    def symmetry_of(self, shape: Array, tolerance: float) -> Symmetry:
        """Return the part of the symmetry that a shape has, to a distance, m.

        Of a mirror it is the x axis or any other that counts.
        """
        kept = [
            motion
            for motion, image in zip(self.motions, self.of(shape), strict=True)
            if rms_distance(image, shape, self._weights) < tolerance
        ]
        turns = sum(not motion.mirrors for motion in kept)
        return Symmetry(turns, any(motion.mirrors for motion in kept))

    @cached_property
    def _interpolations(self) -> list[csr_array]:
        return [interpolation(self.mesh, self.mesh.points @ m.matrix) for m in self.motions]


def _moved(shape: Array, motion: Motion) -> Array:
    return np.column_stack([shape[:, :2] @ motion.matrix.T, shape[:, 2]])


def interpolation(mesh: PlanarMesh, places: Array) -> csr_array:
    """Return the matrix that takes values at the nodes to values at other places, (k, n).

    A place beyond the mesh is taken by the linear function of a triangle near it.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the nodes.
    places : (k, 2) array of float
        In the flat state, m.
    """
    corners = mesh.points[mesh.triangles]
    count = min(NEAR_TRIANGLES, len(corners))
    _, near = cKDTree(corners.mean(axis=1)).query(places, k=count)
    near = near.reshape(len(places), count)
    origin = corners[near, 0]
    sides = np.stack([corners[near, 1] - origin, corners[near, 2] - origin], axis=-1)
    shares = np.linalg.solve(sides, (places[:, None] - origin)[..., None])[..., 0]
    weights = np.concatenate([1 - shares.sum(axis=-1, keepdims=True), shares], axis=-1)
    best = np.argmax(weights.min(axis=-1), axis=1)
    rows = np.arange(len(places))
    nodes = mesh.triangles[near[rows, best]]
    values = weights[rows, best]
    return csr_array(
        (values.reshape(-1), (np.repeat(rows, 3), nodes.reshape(-1))),
        shape=(len(places), len(mesh.points)),
    )
