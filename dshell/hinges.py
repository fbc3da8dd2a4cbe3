"""The bending energy of hinges (paper, eq. 4), and the angle across a hinge with its derivatives.

    E = k/2 (theta - theta_bar)^2

theta is the angle from the normal of the first triangle to that of the second, positive where the
surface is convex toward the normals: a dome seen from outside. With the hinge's unit vector t and
length l and, for its triangle f, the height h, the unit normal n, the unit vector m in the
triangle's plane from the hinge to the apex, the foot s of that height (0 at node 0, 1 at node 1)
and the node weights w = (1 - s, s, -1 at the apex), c = (-1, 1):

    d theta   = sum_f  w (x) n / h
    d^2 theta = sum_f  S[(w (x) n)(w (x) m)^T / h^2 + (c (x) n)(c (x) m)^T / 2 l^2
                         - (w (x) t)(c (x) n)^T / l h],          S[A] = A + A^T

The gradient is that of Bridson, Marino and Fedkiw (2003); the Hessian follows by differentiating
n / h and s, and agrees with Tamstorf and Grinspun (2013), whose form has more terms. The second
term is written as its symmetric part: what it drops cancels between the two triangles.
"""

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dshell.assembly import coordinates_of

Array = NDArray[np.float64]

NUMBERING = (0, 1, 2, 3)
"""Where a hinge's two ends, the apex of its first and that of its second triangle stand."""


@dataclass(frozen=True, eq=False)
class Hinges:
    """Hinges with their natural angles.

    Parameters
    ----------
    nodes : (h, 4) array of int
        Nodes of each hinge as in `dshell.topology`.
    stiffness : (h,) array of float
        k, J.
    natural_angle : (h,) array of float
        theta_bar, rad.
    """

    nodes: NDArray[np.int64]
    stiffness: Array
    natural_angle: Array
    name: ClassVar[str] = "bending"

    @property
    def dofs(self) -> NDArray[np.int64]:
        """Coordinates of each hinge's nodes among all coordinates, shape (h, 4, 3)."""
        return coordinates_of(self.nodes)

    def energy(self, corners: Array) -> Array:
        """Return each hinge's energy, J, shape (h,), from its nodes' positions, (h, 4, 3) in m."""
        return 0.5 * self.stiffness * (hinge_angles(corners) - self.natural_angle) ** 2

    def gradient(self, corners: Array) -> Array:
        """Return the derivative of the energy by the nodes' positions, N, shape (h, 4, 3)."""
        fold = Fold(corners)
        return self._moment(fold)[:, None, None] * fold.gradient

    def hessian(self, corners: Array) -> Array:
        """Return the second derivative by the nodes' positions, N/m, shape (h, 12, 12)."""
        fold = Fold(corners)
        return self._stiffness_part(fold) + fold.hessian(self._moment(fold))

    def convex_hessian(self, corners: Array) -> Array:
        """Return the Hessian without the angle's own curvature: no negative eigenvalue."""
        return self._stiffness_part(Fold(corners))

    def _moment(self, fold: "Fold") -> Array:
        return self.stiffness * (fold.angle - self.natural_angle)

    def _stiffness_part(self, fold: "Fold") -> Array:
        slope = fold.gradient.reshape(-1, 12)
        return self.stiffness[:, None, None] * (slope[:, :, None] * slope[:, None, :])


def hinge_angles(corners: Array) -> Array:
    """Return the angle across each hinge, rad, (-pi, pi], shape (h,), from positions (h, 4, 3)."""
    return Fold(corners).angle


class Fold:
    """The angle across hinges and its derivatives, with the module's formulas.

    Parameters
    ----------
    corners : (h, 4, 3) array of float
        Positions of each hinge's nodes, m.
    numbering : (int, int, int, int)
        Which of them are its ends and its apexes; the derivatives keep the order of `corners`.
    """

    def __init__(self, corners: Array, numbering: tuple[int, int, int, int] = NUMBERING) -> None:
        *self._ends, first_apex, second_apex = numbering
        start, end = (corners[:, node] for node in self._ends)
        edge = end - start
        self._length = np.sqrt(_dot(edge, edge))
        self._along = edge / self._length[:, None]
        self._sides = [
            _side(corners, self._ends, apex, self._length, self._along, turn)
            for apex, turn in ((first_apex, 1.0), (second_apex, -1.0))
        ]

    @property
    def angle(self) -> Array:
        """Angle across each hinge, rad, (-pi, pi], shape (h,)."""
        first, second = (side.normal for side in self._sides)
        return np.arctan2(_dot(self._along, _cross(first, second)), _dot(first, second))

    @property
    def gradient(self) -> Array:
        """Derivative of the angle by the nodes' positions, 1/m, shape (h, 4, 3)."""
        first, second = (_outer(side.weights, side.normal) for side in self._sides)
        return first + second

    def hessian(self, factor: Array) -> Array:
        """Return a factor (h,) times the angle's second derivative, 1/m2, shape (h, 12, 12)."""
        factor = factor[:, None, None]
        ends = np.zeros((len(factor), 4))
        ends[:, self._ends] = np.array([-1.0, 1.0]) / self._length[:, None]  # c / l
        left, right = np.empty((2, len(factor), 4, 4, 3))  # four products of (4, 3) each
        for row, side in zip((0, 2), self._sides, strict=True):
            left[:, row] = factor * _outer(side.weights, side.normal)
            left[:, row + 1] = factor * _outer(ends, side.normal)
            right[:, row] = _outer(side.weights, side.inward)
            right[:, row + 1] = _outer(0.5 * ends, side.inward)
            right[:, row + 1] -= _outer(side.weights, self._along)
        half = left.reshape(-1, 4, 12).transpose(0, 2, 1) @ right.reshape(-1, 4, 12)
        return half + half.transpose(0, 2, 1)


class _Side(NamedTuple):
    """One triangle of each hinge."""

    normal: Array  # n, (h, 3)
    inward: Array  # m, (h, 3)
    weights: Array  # w / height, (h, 4)


def _side(
    corners: Array, ends: list[int], apex: int, length: Array, along: Array, turn: float
) -> _Side:
    start, end = ends
    to_apex = corners[:, apex] - corners[:, start]
    foot = _dot(to_apex, along)
    inward = to_apex - foot[:, None] * along
    height = np.sqrt(_dot(inward, inward))
    inward /= height[:, None]
    weights = np.zeros((len(corners), 4))
    weights[:, end] = foot / length / height
    weights[:, start] = 1 / height - weights[:, end]
    weights[:, apex] = -1 / height
    return _Side(turn * _cross(along, inward), inward, weights)


def _outer(weights: Array, vector: Array) -> Array:
    """Weights (h, 4) of the nodes times a vector (h, 3), shape (h, 4, 3)."""
    return weights[:, :, None] * vector[:, None, :]


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)


def _cross(a: Array, b: Array) -> Array:
    """Cross product of rows; numpy's own takes three times as long on small arrays."""
    x, y, z = a.T
    u, v, w = b.T
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=1)
