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

    def energy(self, corners: Array) -> Array:
        """Return each hinge's energy, J, shape (h,), from its nodes' positions, (h, 4, 3) in m."""
        return 0.5 * self.stiffness * (hinge_angles(corners) - self.natural_angle) ** 2

    def gradient(self, corners: Array) -> Array:
        """Return the derivative of the energy by the nodes' positions, N, shape (h, 4, 3)."""
        hinge, sides = _measure(corners)
        return self._moment(hinge, sides)[:, None, None] * _angle_gradient(sides)

    def hessian(self, corners: Array) -> Array:
        """Return the second derivative by the nodes' positions, N/m, shape (h, 12, 12)."""
        hinge, sides = _measure(corners)
        moment = self._moment(hinge, sides)[:, None, None]
        slope = _angle_gradient(sides)
        ends = np.zeros((len(corners), 4))
        ends[:, :2] = np.array([-1.0, 1.0]) / hinge.length[:, None]  # c / l
        left, right = [0.5 * self.stiffness[:, None, None] * slope], [slope]
        for side in sides:
            bend = _outer(ends, side.normal)
            left += [moment * _outer(side.weights, side.normal), moment * bend]
            right += [
                _outer(side.weights, side.inward),
                0.5 * _outer(ends, side.inward) - _outer(side.weights, hinge.along),
            ]
        half = _as_columns(left) @ _as_columns(right).transpose(0, 2, 1)
        return half + half.transpose(0, 2, 1)

    def _moment(self, hinge: "_HingeLine", sides: "list[_Side]") -> Array:
        return self.stiffness * (_angle(hinge, sides) - self.natural_angle)


def hinge_angles(corners: Array) -> Array:
    """Return the angle across each hinge, rad, (-pi, pi], shape (h,), from positions (h, 4, 3)."""
    return _angle(*_measure(corners))


class _HingeLine(NamedTuple):
    length: Array  # (h,)
    along: Array  # t, (h, 3)


class _Side(NamedTuple):
    """One triangle of each hinge."""

    normal: Array  # n, (h, 3)
    inward: Array  # m, (h, 3)
    weights: Array  # w / height, (h, 4)


def _measure(corners: Array) -> tuple[_HingeLine, list[_Side]]:
    edge = corners[:, 1] - corners[:, 0]
    length = np.sqrt(_dot(edge, edge))
    hinge = _HingeLine(length, edge / length[:, None])
    return hinge, [
        _side(corners, hinge, apex, turn) for apex, turn in zip(APEXES, (1.0, -1.0), strict=True)
    ]


def _side(corners: Array, hinge: _HingeLine, apex: int, turn: float) -> _Side:
    to_apex = corners[:, apex] - corners[:, 0]
    foot = _dot(to_apex, hinge.along)
    inward = to_apex - foot[:, None] * hinge.along
    height = np.sqrt(_dot(inward, inward))
    inward /= height[:, None]
    weights = np.zeros((len(corners), 4))
    weights[:, 1] = foot / hinge.length / height
    weights[:, 0] = 1 / height - weights[:, 1]
    weights[:, apex] = -1 / height
    return _Side(turn * _cross(hinge.along, inward), inward, weights)


def _angle(hinge: _HingeLine, sides: list[_Side]) -> Array:
    first, second = (side.normal for side in sides)
    return np.arctan2(_dot(hinge.along, _cross(first, second)), _dot(first, second))


def _angle_gradient(sides: list[_Side]) -> Array:
    """Return d theta by the nodes' positions, 1/m, shape (h, 4, 3)."""
    first, second = (_outer(side.weights, side.normal) for side in sides)
    return first + second


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
