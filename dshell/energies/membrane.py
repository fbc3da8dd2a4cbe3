"""The stretching of flat triangles: Green strain, constant on each, from the flat bonded state.

With the flat shape functions' slopes B_i (one vector of the plane per corner i) the deformation
gradient is F = sum_i x_i (x) B_i, and E = (F^T F - 1) / 2 is quadratic in the positions:

    dE_ab = sum_i (F_a B_ib + F_b B_ia) . dx_i / 2,
    d2E_ab / dx_i dx_j = (B_ia B_jb + B_ib B_ja) / 2  times the identity.
"""

from copy import copy

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
        at = points.transpose(2, 1, 0)  # (2, 3, m)
        x, y = np.roll(at, -2, axis=1) - np.roll(at, -1, axis=1)  # the sides opposite corner i
        double = x[0] * y[1] - y[0] * x[1]
        self.areas = 0.5 * double
        self.lengths = np.sqrt(x * x + y * y)
        self.outward = np.stack([y, -x]) / self.lengths
        self.slopes = np.stack([-y, x]) / double  # B, (2, 3, m)

    def part(self, block: slice) -> "FlatTriangles":
        """Return some of the triangles."""
        triangles = copy(self)
        triangles.areas, triangles.lengths = self.areas[block], self.lengths[:, block]
        triangles.outward, triangles.slopes = self.outward[:, :, block], self.slopes[:, :, block]
        return triangles

    def at(self, corners: Array) -> "StretchedTriangles":
        """Return the triangles with their corners at positions of shape (3, 3, m): xyz, corner."""
        return StretchedTriangles(self.slopes, corners)

    def strain_hessian(self, force: Array) -> Array:
        """Return forces (3, m) times the second derivative, per pair of corners, shape (m, 3, 3).

        The same for each coordinate, and none between different ones.
        """
        tensor = np.stack([force[0], force[2], force[2], force[1]], axis=1).reshape(-1, 2, 2)
        slopes = self.slopes.transpose(2, 1, 0)
        return slopes @ tensor @ slopes.transpose(0, 2, 1)


class StretchedTriangles:
    """The strain of triangles with its derivative by the corners.

    Parameters
    ----------
    slopes : (2, 3, m) array of float
        B of each corner, 1/m.
    corners : (3, 3, m) array of float
        x, y and z of each corner, m.
    """

    def __init__(self, slopes: Array, corners: Array) -> None:
        self._slopes = slopes
        self.tangents = (slopes[:, None] * corners).sum(axis=2)  # columns of F, (2, 3, m)

    def strain(self) -> Array:
        """Return (Exx, Eyy, 2 Exy), shape (3, m)."""
        x, y = self.tangents
        return np.stack(
            [0.5 * ((x * x).sum(axis=0) - 1), 0.5 * ((y * y).sum(axis=0) - 1), (x * y).sum(axis=0)]
        )

    def strain_gradient(self) -> Array:
        """Return its derivative, 1/m, shape (3, 3, 3, m): strain, xyz, corner."""
        x, y = self.tangents[:, :, None]
        along_x, along_y = self._slopes[:, None]
        return np.stack([x * along_x, y * along_y, x * along_y + y * along_x])

    def forces(self, resultants: Array) -> Array:
        """Return resultants (3, m) times that derivative, shape (3, 3, m): xyz, corner."""
        xx, yy, xy = resultants
        x, y = self.tangents
        pull_x, pull_y = xx * x + xy * y, xy * x + yy * y
        return pull_x[:, None] * self._slopes[0] + pull_y[:, None] * self._slopes[1]
