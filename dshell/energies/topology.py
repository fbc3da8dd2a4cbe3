r"""Who is a neighbour of whom in a triangulation: its edges, and the hinges across them.

A hinge is an edge with a triangle on either side. Its four nodes are numbered

          2
        /   \
       0 --> 1        triangles (0, 1, 2) and (1, 0, 3), both counterclockwise
        \   /
          3
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import InputError


@dataclass(frozen=True, eq=False)
class Topology:
    """Edges and hinges of a triangulation.

    Parameters
    ----------
    edges : (e, 2) array of int
        Nodes of each edge, once each.
    hinges : (h, 4) array of int
        Nodes of each hinge in the order of the module's figure.
    hinge_edges : (h,) array of int
        The row of `edges` that each hinge turns about.
    hinge_faces : (h, 2) array of int
        The two triangles of each hinge: of its node 2 and of its node 3.
    """

    edges: NDArray[np.int64]
    hinges: NDArray[np.int64]
    hinge_edges: NDArray[np.int64]
    hinge_faces: NDArray[np.int64]

    @classmethod
    def of(cls, triangles: NDArray[np.int64]) -> "Topology":
        """Return the edges and hinges of a triangulation.

        Parameters
        ----------
        triangles : (m, 3) array of int
            Nodes of each triangle, counterclockwise.

        Raises
        ------
        InputError
            An edge has more than two triangles, or two that do not run round the same way.
        """
        corners = np.arange(3)
        sides = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2).reshape(-1, 2)
        apexes = triangles[:, (corners + 2) % 3].reshape(-1)
        faces = np.repeat(np.arange(len(triangles)), 3)
        edges, edge_of_side, count = np.unique(
            np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
        )
        edge_of_side = edge_of_side.reshape(-1)
        shared = np.flatnonzero(count[edge_of_side] > 1)
        pairs = shared[np.argsort(edge_of_side[shared], kind="stable")]
        if np.any(count > 2) or np.any(sides[pairs[::2]] != sides[pairs[1::2], ::-1]):
            raise InputError("triangles: expected at most two at an edge, counterclockwise both")
        first, second = pairs[::2], pairs[1::2]
        return cls(
            edges=edges,
            hinges=np.column_stack([sides[first], apexes[first], apexes[second]]),
            hinge_edges=edge_of_side[first],
            hinge_faces=np.column_stack([faces[first], faces[second]]),
        )


@dataclass(frozen=True, eq=False)
class FaceNeighbours:
    """The neighbours across the edges of each triangle; edge i is opposite to corner i.

    Parameters
    ----------
    edge_count : int
        Number of edges.
    edges : (m, 3) array of int
        Each edge's row in `Topology.edges`.
    side : (m, 3) array of float
        1 if the triangle is the first at that edge, -1 if it is the second.
    shared : (m, 3) array of bool
        Whether there is a neighbour.
    apexes : (m, 3) array of int
        The neighbour's far node; the triangle's own if there is none.
    """

    edge_count: int
    edges: NDArray[np.int64]
    side: NDArray[np.float64]
    shared: NDArray[np.bool_]
    apexes: NDArray[np.int64]

    def cut_at(self, sides: NDArray[np.bool_], first: int) -> "FaceNeighbours":
        """Return the neighbours where some triangles have a fixed node of their own beyond an edge.

        Parameters
        ----------
        sides : (m, 3) array of bool
            The edges of the triangles where that is so. One that is inside becomes two edges.
        first : int
            Number of the first of these nodes; they come triangle by triangle.
        """
        edges, apexes = self.edges.copy(), self.apexes.copy()
        count = int(sides.sum())
        apexes[sides] = first + np.arange(count)
        second = sides & (self.side < 0)
        edges[second] = self.edge_count + np.arange(second.sum())
        return replace(
            self,
            edge_count=self.edge_count + int(second.sum()),
            edges=edges,
            side=np.where(sides, 1.0, self.side),
            shared=self.shared | sides,
            apexes=apexes,
        )

    @classmethod
    def of(cls, triangles: NDArray[np.int64]) -> "FaceNeighbours":
        """Return the neighbours in a triangulation; InputError as by `Topology.of`."""
        topology = Topology.of(triangles)
        ends = np.sort(np.stack([triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]], axis=2), axis=2)
        count = triangles.max() + 1
        edges = np.searchsorted(topology.edges @ np.array([count, 1]), ends @ np.array([count, 1]))
        shape = (len(topology.edges), 2)
        apexes, faces = np.full(shape, -1), np.full(shape, -1)
        apexes[topology.hinge_edges] = topology.hinges[:, [2, 3]]
        faces[topology.hinge_edges] = topology.hinge_faces
        second = faces[edges, 1] == np.arange(len(triangles))[:, None]
        across = apexes[edges, np.where(second, 0, 1)]
        return cls(
            edge_count=len(topology.edges),
            edges=edges,
            side=np.where(second, -1.0, 1.0),
            shared=across >= 0,
            apexes=np.where(across >= 0, across, triangles),
        )


def sum_at_nodes(triangles: NDArray[np.int64], values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return, for each node, the sum of a value over its triangles.

    Parameters
    ----------
    triangles : (m, 3) array of int
        Nodes of each triangle.
    values : (m,) array of float
        One value per triangle.
    """
    total = np.bincount(triangles.reshape(-1), np.repeat(values, 3))
    return total.astype(np.float64, copy=False)
