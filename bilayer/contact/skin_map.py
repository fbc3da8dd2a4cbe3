"""The skin as a smooth function of a surface: its points, and their derivatives.

A point of the skin lies on the fibre through a node x of the surface, at the flat height z:

    y = x + z A0 N / |N|^2.

N is the sum of the area vectors around the node and A0 its value on the flat sheet. The fibre is
straight and along the normal, and as high as it was over the area stretch, so that it keeps its
volume. The triangles around the node are those of the layer itself, so that a bare wedge that is
folded does not tilt the layer beside it; at nodes without the layer they are all triangles.

The area vector of a triangle is (a x b + b x c + c x a) / 2: quadratic in its corners. With
s = |N|^2, the derivatives of g = N / s are

    dg = (I - 2 N N'/s) / s dN,
    p . d2g = dN' [ -2 (p.N I + p N' + N p') / s^2 + 8 p.N N N' / s^3 ] dN + (dg/dN p) . d2N.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csr_matrix, vstack

from bilayer.contact.skin import BondedBody, sides_of, skin_triangles
from bilayer.mesh.planar import flat_surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

XYZ = np.arange(3)


@dataclass(frozen=True, eq=False)
class SkinMap:
    """The points of a skin as functions of the nodes of a surface.

    Parameters
    ----------
    mesh_triangles : (m, 3) array of int
        The surface.
    triangles : (t, 3) array of int
        The closed skin, turned outward, by its points.
    face : (t,) array of int
        The mesh's triangle that each of them covers.
    node : (k,) array of int
        The node whose fibre each point lies on.
    side : (k,) array of int
        The side of a layer that it lies on, see `bilayer.contact.skin.sides_of`.
    heights : (k,) array of float
        z, m.
    around : (k, m) sparse matrix
        1 for the triangles whose area vectors make up a point's N.
    flat_areas : (k,) array of float
        A0, m2.
    """

    mesh_triangles: Indices
    triangles: Indices
    face: Indices
    node: Indices
    side: Indices
    heights: Array
    around: csr_matrix
    flat_areas: Array

    @classmethod
    def of(cls, body: BondedBody) -> "SkinMap":
        """Return the skin of a body over its reference surface."""
        triangles, face = skin_triangles(body)
        used, place = np.unique(triangles, return_inverse=True)
        side, node = np.divmod(used, len(body.mesh.points))
        around = _faces_around(body, side, node)
        flat = flat_surface(body.mesh)
        return cls(
            body.mesh.triangles,
            place.reshape(triangles.shape),
            face,
            node,
            side,
            _heights(body)[side],
            around,
            around @ flat.areas,
        )

    def at_heights_of(self, body: BondedBody) -> "SkinMap":
        """Return the skin of a body of the same layers on the same mesh, of other thickness."""
        return replace(self, heights=_heights(body)[self.side])

    def points(self, nodes: Array) -> Array:
        """Return the points of the skin, m, (k, 3), from the nodes of the surface, (n, 3)."""
        normal = self.around @ self._area_vectors(nodes)
        scale = self.heights * self.flat_areas / (normal**2).sum(axis=1)
        return np.take(nodes, self.node, axis=0) + scale[:, None] * normal

    def pull_back(self, nodes: Array, gradient: Array) -> Array:
        """Return the gradient by the nodes, (n, 3), of a function given that by the points."""
        normal = self.around @ self._area_vectors(nodes)
        by_normal = (self.heights * self.flat_areas)[:, None] * _along_fibre(normal, gradient)
        by_vectors = self.around.T @ by_normal
        total = np.zeros_like(nodes)
        for corner, opposite in enumerate(self._opposite_edges(nodes)):
            part = 0.5 * np.cross(opposite, by_vectors)
            _add_at(total, self.mesh_triangles[:, corner], part)
        _add_at(total, self.node, gradient)
        return total

    def pull_back_hessian(self, nodes: Array, gradient: Array, hessian: csr_matrix) -> csr_matrix:
        """Return the second derivative by the nodes, (3 n, 3 n), given those by the points.

        Parameters
        ----------
        nodes : (n, 3) array of float
            The surface, m.
        gradient : (k, 3) array of float
            Derivative of a function by the points.
        hessian : (3 k, 3 k) sparse matrix
            Its second derivative. Points whose rows and gradients are zero cost nothing.
        """
        active = np.flatnonzero(
            np.bincount(hessian.indices // 3, minlength=len(self.node))
            + np.any(gradient != 0, axis=1)
        )
        normal = (self.around @ self._area_vectors(nodes))[active]
        scale = (self.heights * self.flat_areas)[active]
        turn = self._normal_derivative(nodes, active)
        fibre = _blocks(scale[:, None, None] * _fibre_derivative(normal))
        places = 3 * self.node[active, None] + XYZ
        here = _rows(places, 3 * len(nodes))
        jacobian = here + fibre @ turn
        dofs = (3 * active[:, None] + XYZ).reshape(-1)
        active_hessian = hessian[dofs][:, dofs]
        bend = _blocks(scale[:, None, None] * _fibre_curvature(normal, gradient[active]))
        total = jacobian.T @ active_hessian @ jacobian + turn.T @ bend @ turn
        by_normal = scale[:, None] * _along_fibre(normal, gradient[active])
        by_vectors = self.around[active].T @ by_normal
        return (total + self._area_curvature(by_vectors, len(nodes))).tocsr()

    def _area_vectors(self, nodes: Array) -> Array:
        a, b, c = np.moveaxis(np.take(nodes, self.mesh_triangles, axis=0), 1, 0)
        return 0.5 * np.cross(b - a, c - a)

    def _opposite_edges(self, nodes: Array) -> Array:
        """Return, for each corner, the edge from the one before to the next, (3, m, 3)."""
        corners = np.moveaxis(np.take(nodes, self.mesh_triangles, axis=0), 1, 0)
        return np.roll(corners, -1, axis=0) - np.roll(corners, -2, axis=0)

    def _normal_derivative(self, nodes: Array, active: Indices) -> csr_matrix:
        """Return the derivative of N of some points by the nodes, (3 k, 3 n)."""
        pairs = self.around[active].tocoo()
        edges = self._opposite_edges(nodes)[:, pairs.col]
        blocks = -0.5 * _cross_matrices(edges)
        rows = np.broadcast_to(3 * pairs.row[:, None] + XYZ, (3, len(pairs.row), 3))
        columns = 3 * self.mesh_triangles[pairs.col].T[..., None] + XYZ
        return _matrix(blocks, rows, columns, (3 * len(active), 3 * len(nodes)))

    def _area_curvature(self, by_vectors: Array, nodes: int) -> csr_matrix:
        """Return the second derivative of the area vectors times some vectors, (m, 3)."""
        faces = np.flatnonzero(np.any(by_vectors != 0, axis=1))
        cross = 0.5 * _cross_matrices(by_vectors[faces])
        corners = 3 * self.mesh_triangles[faces].T[..., None] + XYZ
        following = np.roll(corners, -1, axis=0)
        blocks = np.stack([-cross] * 3 + [cross] * 3)
        rows, columns = (
            np.concatenate(pair) for pair in ((corners, following), (following, corners))
        )
        return _matrix(blocks, rows, columns, (3 * nodes, 3 * nodes))


def _heights(body: BondedBody) -> Array:
    """Return the height of each side over the reference surface, that one first."""
    sides, _ = sides_of(body)
    return np.array([0.0, *(side.height for side in sides)])


def _faces_around(body: BondedBody, side: Indices, node: Indices) -> csr_matrix:
    """Return the triangles around each point that its fibre is normal to, (k, m)."""
    triangles = body.mesh.triangles
    count, nodes = len(triangles), len(body.mesh.points)
    places = triangles.reshape(-1), np.repeat(np.arange(count), 3)
    everywhere = csr_matrix((np.ones(3 * count), places), shape=(nodes, count))
    sides, _ = sides_of(body)
    families = [everywhere]
    for own in sides:
        covered = np.zeros(count)
        covered[own.faces] = 1.0
        mine = everywhere.multiply(covered[None]).tocsr()
        bare = np.asarray(mine.sum(axis=1)).reshape(-1) == 0
        families.append((mine + everywhere.multiply(bare[:, None])).tocsr())
    chosen = [family[node[side == number]] for number, family in enumerate(families)]
    order = np.argsort(np.argsort(side, kind="stable"))
    stacked = vstack(chosen).tocsr()[order]
    stacked.eliminate_zeros()
    return stacked


def _along_fibre(normal: Array, vectors: Array) -> Array:
    """Return the derivative of N / |N|^2 times vectors, (k, 3); it is symmetric."""
    square = (normal**2).sum(axis=1)[:, None]
    along = (normal * vectors).sum(axis=1)[:, None]
    return (vectors - 2 * along / square * normal) / square


def _fibre_derivative(normal: Array) -> Array:
    """Return the derivative of N / |N|^2, (k, 3, 3)."""
    square = (normal**2).sum(axis=1)[:, None, None]
    outer = normal[:, :, None] * normal[:, None]
    return (np.eye(3) - 2 * outer / square) / square


def _fibre_curvature(normal: Array, vectors: Array) -> Array:
    """Return the second derivative of vectors . N / |N|^2, (k, 3, 3)."""
    square = (normal**2).sum(axis=1)[:, None, None]
    along = (normal * vectors).sum(axis=1)[:, None, None]
    mixed = vectors[:, :, None] * normal[:, None]
    mixed = mixed + mixed.swapaxes(1, 2) + along * np.eye(3)
    outer = normal[:, :, None] * normal[:, None]
    return -2 * mixed / square**2 + 8 * along * outer / square**3


def _cross_matrices(vectors: Array) -> Array:
    """Return the matrices [v] of which [v] w = v x w, (..., 3, 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _blocks(blocks: Array) -> csr_matrix:
    """Return the block-diagonal matrix of blocks, (k, 3, 3)."""
    places = 3 * np.arange(len(blocks))[:, None] + XYZ
    return _matrix(blocks, places, places, (3 * len(blocks), 3 * len(blocks)))


def _rows(places: Indices, columns: int) -> csr_matrix:
    """Return the matrix that picks entries."""
    count = places.size
    entries = (np.ones(count), (np.arange(count), places.reshape(-1)))
    return csr_matrix(entries, shape=(count, columns))


def _matrix(blocks: Array, rows: Indices, columns: Indices, shape: tuple[int, int]) -> csr_matrix:
    """Return the sum of blocks (..., 3, 3) at rows and columns (..., 3)."""
    all_rows = np.broadcast_to(rows[..., None], blocks.shape).reshape(-1)
    all_columns = np.broadcast_to(columns[..., None, :], blocks.shape).reshape(-1)
    return coo_matrix((blocks.reshape(-1), (all_rows, all_columns)), shape=shape).tocsr()


def _add_at(total: Array, places: Indices, values: Array) -> None:
    """Add values (k, 3) at places of an array (n, 3); one may come more than once."""
    for axis in range(3):
        total[:, axis] += np.bincount(places, values[:, axis], minlength=len(total))
