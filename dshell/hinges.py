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

APEXES = (2, 3)
"""Where the apex of the first and of the second triangle stands among a hinge's nodes."""


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
    """

    def __init__(self, corners: Array) -> None:
        edge = corners[:, 1] - corners[:, 0]
        self._length = np.sqrt(_dot(edge, edge))
        self._along = edge / self._length[:, None]
        self._sides = [
            _side(corners, self._length, self._along, apex, turn)
            for apex, turn in zip(APEXES, (1.0, -1.0), strict=True)
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
        ends[:, :2] = np.array([-1.0, 1.0]) / self._length[:, None]  # c / l
        left, right = [], []
        for side in self._sides:
            left += [
                factor * _outer(side.weights, side.normal),
                factor * _outer(ends, side.normal),
            ]
            right += [
                _outer(side.weights, side.inward),
                0.5 * _outer(ends, side.inward) - _outer(side.weights, self._along),
            ]
        half = _as_columns(left) @ _as_columns(right).transpose(0, 2, 1)
        return half + half.transpose(0, 2, 1)


class _Side(NamedTuple):
    """One triangle of each hinge."""

    normal: Array  # n, (h, 3)
    inward: Array  # m, (h, 3)
    weights: Array  # w / height, (h, 4)


def _side(corners: Array, length: Array, along: Array, apex: int, turn: float) -> _Side:
    to_apex = corners[:, apex] - corners[:, 0]
    foot = _dot(to_apex, along)
    inward = to_apex - foot[:, None] * along
    height = np.sqrt(_dot(inward, inward))
    inward /= height[:, None]
    weights = np.zeros((len(corners), 4))
    weights[:, 1] = foot / length / height
    weights[:, 0] = 1 / height - weights[:, 1]
    weights[:, apex] = -1 / height
    return _Side(turn * _cross(along, inward), inward, weights)


def _outer(weights: Array, vector: Array) -> Array:
    """Weights (h, 4) of the nodes times a vector (h, 3), shape (h, 4, 3)."""
    return weights[:, :, None] * vector[:, None, :]


def _as_columns(terms: list[Array]) -> Array:
    """Terms of shape (h, 4, 3) as the columns of a matrix per hinge, shape (h, 12, terms)."""
    return np.stack([term.reshape(len(term), 12) for term in terms], axis=2)


def _dot(a: Array, b: Array) -> Array:
    return (a * b).sum(axis=1)


def _cross(a: Array, b: Array) -> Array:
    """Cross product of rows; numpy's own takes three times as long on small arrays."""
    x, y, z = a.T
    u, v, w = b.T
    return np.column_stack([y * w - z * v, z * u - x * w, x * v - y * u])
