"""The stretching of flat triangles: Green strain, constant on each, from the flat bonded state.

With the flat shape functions' slopes B_i (one vector of the plane per corner i) the deformation
gradient is F = sum_i x_i (x) B_i, and E = (F^T F - 1) / 2 is quadratic in the positions:

    dE_ab = sum_i (F_a B_ib + F_b B_ia) . dx_i / 2,
    d2E_ab / dx_i dx_j = (B_ia B_jb + B_ib B_ja) / 2  times the identity.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class FlatTriangles:
    """Triangles with their flat bonded state.

    Parameters
    ----------
    points : (m, 3, 2) array of float
        Flat corners, counterclockwise, m.
    """

    def __init__(self, points: Array) -> None:
        sides = np.roll(points, -2, axis=1) - np.roll(points, -1, axis=1)  # opposite corner i
        double = sides[:, 0, 0] * sides[:, 1, 1] - sides[:, 0, 1] * sides[:, 1, 0]
        self.areas = 0.5 * double
        self.lengths = np.sqrt((sides * sides).sum(axis=2))
        self.outward = np.stack([sides[..., 1], -sides[..., 0]], axis=2) / self.lengths[..., None]
        self._slopes = np.stack([-sides[..., 1], sides[..., 0]], axis=2) / double[:, None, None]

    def strain(self, corners: Array) -> Array:
        """Return (Exx, Eyy, 2 Exy), shape (3, m), from positions of shape (m, 3, 3)."""
        x, y = self._tangents(corners)
        return np.stack([((x * x).sum(1) - 1) / 2, ((y * y).sum(1) - 1) / 2, (x * y).sum(1)])

    def strain_gradient(self, corners: Array) -> Array:
        """Return its derivative by the corners, 1/m, shape (m, 3, 3, 3): strain, corner, xyz."""
        x, y = (tangent[:, None] for tangent in self._tangents(corners))
        along_x, along_y = self._slopes[..., 0, None], self._slopes[..., 1, None]
        return np.stack([x * along_x, y * along_y, x * along_y + y * along_x], axis=1)

    def strain_hessian(self, force: Array) -> Array:
        """Return forces (3, m) times the second derivative, per pair of corners, shape (m, 3, 3).

        The same for each coordinate, and none between different ones.
        """
        tensor = np.stack([force[0], force[2], force[2], force[1]], axis=1).reshape(-1, 2, 2)
        return self._slopes @ tensor @ self._slopes.transpose(0, 2, 1)

    def _tangents(self, corners: Array) -> Array:
        """Columns of F, shape (2, m, 3)."""
        return np.moveaxis(self._slopes.transpose(0, 2, 1) @ corners, 1, 0)
