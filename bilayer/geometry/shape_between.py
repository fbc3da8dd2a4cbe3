"""Shapes between two shapes of one mesh, each triangle turned and stretched a share of the way.

Straight ways of the nodes press the triangles of a bent sheet flat, or turn them inside out. Here
each triangle gets the share of its own turn and stretch, and the nodes lie where the sides of the
triangles fit best (as in Xu, Zhang, Wang and Bao, Poisson shape interpolation, 2005).
"""

from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]


class ShapesBetween:
    """The shapes between two.

    Parameters
    ----------
    first, second : (n, 3) array of float
        The shapes, one laid onto the other, m.
    triangles : (m, 3) array of int
        Of both.
    """

    def __init__(self, first: Array, second: Array, triangles: NDArray[np.int64]) -> None:
        self._first, self._second, self._triangles = first, second, triangles
        self._frames = _frames(first[triangles])
        change = _frames(second[triangles]) @ np.linalg.inv(self._frames)
        left, stretches, right = np.linalg.svd(change)
        turns = scipy.spatial.transform.Rotation.from_matrix(left @ right)
        self._turns = turns.as_rotvec()
        self._stretches = np.swapaxes(right, 1, 2) @ (stretches[:, :, None] * right)

    def at(self, share: float) -> Array:
        """Return the shape at a share of the way from the first to the second, (n, 3), m.

        Examples
        --------
        >>> flat = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
        >>> turned = flat[:, [2, 0, 1]]
        >>> between = ShapesBetween(flat, turned, np.array([[0, 1, 2]])).at(0.5)
        >>> sides = np.linalg.norm(between[1:] - between[0], axis=1)
        >>> [round(float(side), 9) for side in sides]
        [1.0, 1.0]
        """
        turns = scipy.spatial.transform.Rotation.from_rotvec(share * self._turns).as_matrix()
        grown = (1 - share) * np.eye(3) + share * self._stretches
        sides = np.swapaxes((turns @ grown @ self._frames)[:, :, :2], 1, 2)
        wanted = np.stack([sides[:, 0], sides[:, 1] - sides[:, 0], -sides[:, 1]], axis=1)
        right = self._differences.T @ wanted.reshape(-1, 3)
        centre = (1 - share) * self._first.mean(axis=0) + share * self._second.mean(axis=0)
        fitted = np.zeros_like(self._first)
        fitted[1:] = self._factor.solve(right[1:])
        return np.asarray(fitted - fitted.mean(axis=0) + centre)

    @cached_property
    def _differences(self) -> scipy.sparse.csr_array:
        """The matrix from nodes to the sides of triangles, (3 m, n)."""
        start = self._triangles.reshape(-1)
        end = np.roll(self._triangles, -1, axis=1).reshape(-1)
        rows = np.tile(np.arange(len(start)), 2)
        signs = np.repeat([1.0, -1.0], len(start))
        shape = len(start), len(self._first)
        return scipy.sparse.csr_array((signs, (rows, np.concatenate([end, start]))), shape=shape)

    @cached_property
    def _factor(self) -> scipy.sparse.linalg.SuperLU:
        """The factorised normal equations, the first node being held."""
        normal = (self._differences.T @ self._differences).tocsc()[1:, 1:]
        return scipy.sparse.linalg.splu(normal)


def _frames(corners: Array) -> Array:
    """Return two sides and the unit normal of triangles as columns, (m, 3, 3)."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normal = np.cross(first, second)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return np.stack([first, second, normal], axis=-1)
