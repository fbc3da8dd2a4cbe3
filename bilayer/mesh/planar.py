"""The planar mesh that both solvers share: points, triangles, and which layers lie on each.

The shell uses it as it is, the finite-element model extrudes it, so that two results differ by
their models and not by their meshes.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from bilayer.errors import InputError
from bilayer.geometry.surface import Surface, directed_edges
from bilayer.mesh.validity import check_points, check_region, check_sheet
from bilayer.specimen.two_layers import TWO_LAYERS

ROUND_OFF = 1e-9
"""Distance over the extent of the mesh that counts as none."""


@dataclass(frozen=True, eq=False)
class PlanarMesh:
    """A triangulation of the bonded flat sheet. Its arrays are its own and cannot be written to.

    Parameters
    ----------
    points : (n, 2) array of float
        Node coordinates in the bonded flat state, m.
    triangles : (m, 3) array of int
        Nodes of each triangle, counterclockwise.
    region : (m,) array of int
        Number of the set of layers that lie on each triangle.
    layer_sets : sequence of frozenset of str
        The sets: names of the layers in each region. A bilayer's unless told: 0 the bare substrate,
        1 substrate and kirigami.

    Raises
    ------
    InputError
        Shapes or indices do not fit, or it is no single sheet; see `bilayer.mesh.validity`.

    Examples
    --------
    >>> import bilayer, numpy as np
    >>> points = np.array([[0.0, 0.0], [0.01, 0.0], [0.01, 0.01], [0.0, 0.01]])
    >>> mesh = bilayer.PlanarMesh(points, np.array([[0, 1, 2], [0, 2, 3]]), np.array([1, 1]))
    >>> len(mesh.triangles)
    2
    """

    points: NDArray[np.float64]
    triangles: NDArray[np.int64]
    region: NDArray[np.int64]
    layer_sets: tuple[frozenset[str], ...] = TWO_LAYERS

    def __post_init__(self) -> None:
        sets = tuple(frozenset(names) for names in self.layer_sets)
        object.__setattr__(self, "layer_sets", sets)
        known = tuple(number for number, names in enumerate(sets) if names)
        check_region(self.region, known)  # as given, before it becomes whole numbers
        for name, kind in (("points", np.float64), ("triangles", np.int64), ("region", np.int64)):
            own = np.array(getattr(self, name), dtype=kind, order="C")
            own.flags.writeable = False
            object.__setattr__(self, name, own)
        self._check_shapes()
        check_points(self.points)
        check_sheet(self.points, self.triangles)

    def _check_shapes(self) -> None:
        expected = {
            "points": (self.points, (len(self.points), 2)),
            "triangles": (self.triangles, (len(self.triangles), 3)),
            "region": (self.region, (len(self.triangles),)),
        }
        for name, (array, shape) in expected.items():
            if array.shape != shape or 0 in shape:
                raise InputError(f"{name} has shape {array.shape}: expected {shape}, not empty")

    @cached_property
    def areas(self) -> NDArray[np.float64]:
        """Signed area of each triangle, m2, shape (m,)."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])

    @cached_property
    def edges(self) -> NDArray[np.int64]:
        """Each edge once, as ascending node pairs in ascending order, shape (e, 2)."""
        return np.unique(_corner_pairs(self.triangles), axis=0)

    @cached_property
    def boundary_edges(self) -> NDArray[np.int64]:
        """Edges that belong to a single triangle, shape (b, 2)."""
        return self.edges_of(np.arange(len(self.triangles)))

    @cached_property
    def rim_nodes(self) -> NDArray[np.int64]:
        """Nodes on the outer boundary, ascending; those on the edges of holes are not among them.

        A hole that meets the outer boundary in a node counts as a part of it.
        """
        nodes, ends = np.unique(self.boundary_edges, return_inverse=True)
        start, end = ends.reshape(-1, 2).T
        pairs = scipy.sparse.coo_array(
            (np.ones(len(start)), (start, end)), shape=(len(nodes), len(nodes))
        )
        _, loop = scipy.sparse.csgraph.connected_components(pairs, directed=False)
        outermost = np.argmax(self.points[nodes, 0])
        return nodes[loop == loop[outermost]]

    @cached_property
    def centroid(self) -> NDArray[np.float64]:
        """Centre of the sheet's area, m, shape (2,); 0 if it is not away from it but for round-off.

        It need not lie on the sheet.
        """
        centre = self.areas @ self.points[self.triangles].mean(axis=1) / self.areas.sum()
        return np.where(np.abs(centre) > ROUND_OFF * np.ptp(self.points), centre, 0.0)

    @cached_property
    def centre_node(self) -> int:
        """The node nearest to the centroid."""
        from_centre = self.points - self.centroid
        return int(np.argmin(np.einsum("ij,ij->i", from_centre, from_centre)))

    def faces_of(self, layer: str) -> NDArray[np.int64]:
        """Return the triangles that a layer covers, ascending."""
        there = [number for number, names in enumerate(self.layer_sets) if layer in names]
        return np.flatnonzero(np.isin(self.region, there))

    def edges_of(self, faces: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the edges that belong to one of some triangles alone, shape (b, 2)."""
        edges, count = np.unique(_corner_pairs(self.triangles[faces]), axis=0, return_counts=True)
        return edges[count == 1]

    def with_points(self, points: NDArray[np.float64]) -> "PlanarMesh":
        """Return the same triangles and layers with their nodes elsewhere, m, (n, 2)."""
        return replace(self, points=points)

    def same_as(self, other: "PlanarMesh") -> bool:
        """Whether the other mesh has the same nodes, triangles and regions (points to 1e-12 m)."""
        return (
            self.points.shape == other.points.shape
            and np.array_equal(self.triangles, other.triangles)
            and np.array_equal(self.region, other.region)
            and self.layer_sets == other.layer_sets
            and np.allclose(self.points, other.points, rtol=0.0, atol=1e-12)
        )


def _corner_pairs(triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.sort(directed_edges(triangles), axis=1)


def flat_surface(mesh: PlanarMesh) -> Surface:
    """Return the bonded flat state as a surface in space, z = 0."""
    return Surface(np.pad(mesh.points, ((0, 0), (0, 1))), mesh.triangles)
