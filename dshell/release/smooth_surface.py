"""A smooth surface through the nodes of a flat mesh, on the sheet and a little beyond its edges.

On the sheet it is scipy's cubic interpolation between the Delaunay triangles of the nodes. These
also fill holes and bridge notches, whose two sides can be far apart once the sheet is released. So
the slopes at the nodes are estimated from edges that lie on the sheet alone, and a point in a
triangle that does not lie on the sheet is extrapolated from the nearest triangle of the mesh.
"""

from functools import cached_property

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.interpolate import CloughTocher2DInterpolator
from scipy.spatial import Delaunay, cKDTree

from bilayer.geometry.surface import directed_edges
from bilayer.mesh.planar import PlanarMesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

CANDIDATES = 12
"""Triangles, those of the nearest centres, among which the nearest to a point is looked for."""


class SmoothSurface:
    """A smooth surface over a flat sheet.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the sheet.
    values : (n, k) array of float
        At its nodes.
    """

    def __init__(self, mesh: PlanarMesh, values: Array) -> None:
        self._mesh, self._values = mesh, values
        self._triangles = SheetDelaunay(mesh)
        self._cubic = CloughTocher2DInterpolator(self._triangles, values)

    def at(self, points: Array) -> Array:
        """Return the values at points of the sheet or near it, (m, 2) in m, shape (m, k)."""
        found = self._triangles.find_simplex(points)
        within = (found >= 0) & self._triangles.on_sheet[found]
        values = np.empty((len(points), self._values.shape[1]))
        values[within] = self._cubic(points[within])
        values[~within] = self._extrapolated(points[~within])
        return values

    def _extrapolated(self, points: Array) -> Array:
        """Return the values of the nearest triangles' quadratic surfaces, shape (m, k).

        With the shares s of the corners in a point p, the sum of s (f + g.(p - x) / 2) over the
        values f and slopes g at the corners x is exact for a quadratic f.
        """
        nodes, shares = self._nearest_triangle(points)
        away = points[:, None] - self._mesh.points[nodes]
        slopes = np.asarray(self._cubic.grad)[nodes]
        rise = np.einsum("mci,mcki->mck", away, slopes)
        return np.einsum("mc,mck->mk", shares, self._values[nodes] + rise / 2)

    def _nearest_triangle(self, points: Array) -> tuple[Indices, Array]:
        """Return the corners of the triangle nearest to each point, and their shares in it, (m, 3).

        It is the one whose least share is the greatest: not negative if the point lies in it.
        """
        mesh = self._mesh
        centres = mesh.points[mesh.triangles].mean(axis=1)
        count = min(CANDIDATES, len(centres))
        near = cKDTree(centres).query(points, k=np.arange(1, count + 1))[1]
        shares = _shares_of_corners(mesh.points[mesh.triangles[near]], points[:, None])
        best = np.argmax(shares.min(axis=2), axis=1)[:, None]
        nodes = mesh.triangles[np.take_along_axis(near, best, axis=1)[:, 0]]
        return nodes, np.take_along_axis(shares, best[:, :, None], axis=1)[:, 0]


class SheetDelaunay(Delaunay):  # type: ignore[misc]  # scipy has no types
    """The Delaunay triangles of a mesh's nodes, neighbours being those joined on the sheet.

    Parameters
    ----------
    mesh : PlanarMesh
        Of the sheet.
    """

    def __init__(self, mesh: PlanarMesh) -> None:
        super().__init__(mesh.points)
        self._mesh = mesh

    @cached_property
    def on_sheet(self) -> NDArray[np.bool_]:
        """Whether each triangle lies on the sheet, shape (t,)."""
        points = self._mesh.points
        sheet = shapely.coverage_union_all(shapely.polygons(points[self._mesh.triangles]))
        shapely.prepare(sheet)
        return np.asarray(shapely.covers(sheet, shapely.polygons(points[self.simplices])))

    @cached_property
    def vertex_neighbor_vertices(self) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        """Neighbours of each node as `scipy.spatial.Delaunay` has them: starts, then all in a row.

        A node of no triangle that lies on the sheet has its neighbours in the mesh.
        """
        t = self.simplices[self.on_sheet]
        alone = np.setdiff1d(np.arange(len(self._mesh.points)), t)
        edges = self._mesh.edges[np.isin(self._mesh.edges, alone).any(axis=1)]
        sides = np.concatenate([directed_edges(t), edges])
        pairs = np.unique(np.concatenate([sides, sides[:, ::-1]]), axis=0)
        starts = np.searchsorted(pairs[:, 0], np.arange(len(self._mesh.points) + 1))
        return starts.astype(np.int32), pairs[:, 1].astype(np.int32)


def _shares_of_corners(corners: Array, points: Array) -> Array:
    """Return barycentric coordinates of points, (..., 2), in triangles, (..., 3, 2)."""
    from_points = corners - points[..., None, :]
    x, y = np.moveaxis(from_points, -1, 0)
    doubled = np.stack([_cross(x, y, k, (k + 1) % 3) for k in (1, 2, 0)], axis=-1)
    return doubled / doubled.sum(axis=-1, keepdims=True)


def _cross(x: Array, y: Array, first: int, second: int) -> Array:
    return x[..., first] * y[..., second] - x[..., second] * y[..., first]
