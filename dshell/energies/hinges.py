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

The normals tell the angle up to whole turns. The surface knows how often it went round, so the
state holds that number for each fold (see `dshell.energies.whole_turns`).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dshell.energies.assembly import coordinates_of, sum_at
from dshell.energies.whole_turns import FULL_TURN, turns_in

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Hinges:
    """Hinges with their natural angles.

    Parameters
    ----------
    nodes : (h, 4) array of int
        Nodes of each hinge as in `dshell.energies.topology`.
    stiffness : (h,) array of float
        k, J.
    natural_angle : (h,) array of float
        theta_bar, rad.
    turn_dofs : (h,) array of int, optional
        Place of each hinge's whole turns in the state; none if left out.
    """

    nodes: NDArray[np.int64]
    stiffness: Array
    natural_angle: Array
    turn_dofs: NDArray[np.int64] | None = None
    name: ClassVar[str] = "bending"

    @cached_property
    def dofs(self) -> NDArray[np.int64]:
        """Coordinates of each hinge's nodes in the state, (3, 4, h)."""
        return fold_dofs(self.nodes)

    @property
    def stencils(self) -> list[NDArray[np.int64]]:
        """The same, all x first, then y, z, (h, 12); see `dshell.energies.assembly.Energy`."""
        return [self.dofs.reshape(12, -1).T]

    def at(self, state: Array) -> "_TurnedHinges":
        """Return the hinges in a state; see `dshell.energies.assembly.Energy`."""
        return _TurnedHinges(self, state)


class _TurnedHinges:
    def __init__(self, hinges: Hinges, state: Array) -> None:
        self._hinges = hinges
        self._size = len(state)
        self._fold = Fold(state[hinges.dofs], turns_in(state, hinges.turn_dofs))
        self._turn = self._fold.angle - hinges.natural_angle

    @property
    def turn_dofs(self) -> NDArray[np.int64] | None:
        """See `dshell.energies.whole_turns.Folded`."""
        return self._hinges.turn_dofs

    @property
    def angles(self) -> Array:
        """See `dshell.energies.whole_turns.Folded`."""
        return self._fold.angle

    def energy(self) -> Array:
        """See `dshell.energies.assembly.Deformed`."""
        return 0.5 * self._hinges.stiffness * self._turn**2

    def gradient(self) -> Array:
        """See `dshell.energies.assembly.Deformed`."""
        forces = self._hinges.stiffness * self._turn * self._fold.gradient
        return sum_at(self._hinges.dofs, forces, self._size)

    def hessian(self) -> list[Array]:
        """See `dshell.energies.assembly.Deformed`."""
        left, right = self._fold.hessian_rows()
        moment, gradient = self._hinges.stiffness * self._turn, self._fold.gradient[None]
        left = np.concatenate([moment * left, self._half_stiff()])
        return [fold_product(left, np.concatenate([right, gradient]))]

    def convex_hessian(self) -> list[Array]:
        """Return the Hessian without the angle's own curvature: no negative eigenvalue."""
        return [fold_product(self._half_stiff(), self._fold.gradient[None])]

    def _half_stiff(self) -> Array:
        return 0.5 * self._hinges.stiffness * self._fold.gradient[None]


def fold_dofs(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the places of hinges' coordinates in the state: (h, 4) nodes give (3, 4, h)."""
    return np.ascontiguousarray(coordinates_of(nodes).transpose(2, 1, 0))


def hinge_angles(corners: Array) -> Array:
    """Return the angle across each hinge, rad, (-pi, pi], shape (h,), from positions (h, 4, 3)."""
    return Fold(corners.transpose(2, 1, 0)).angle


class Fold:
    """The angle across hinges and its derivatives, with the module's formulas.

    Parameters
    ----------
    corners : (3, 4, ...) array of float
        x, y and z of each hinge's two ends and of the apexes of its first and second triangle, m.
    turns : array of float or float
        Whole turns of each hinge beyond what the normals tell.
    """

    def __init__(self, corners: Array, turns: Array | float = 0.0) -> None:
        self._turns = turns
        edge = corners[:, 1] - corners[:, 0]
        self._length = np.sqrt(_dot(edge, edge))
        self._along = edge / self._length
        to_apexes = corners[:, 2:] - corners[:, :1]
        along = self._along[:, None]
        foot = _dot(to_apexes, along)
        inward = to_apexes - foot * along
        height = np.sqrt(_dot(inward, inward))
        self._inward = inward / height  # m of both triangles, (3, 2, ...)
        self._normal = _cross(along, self._inward)  # n
        self._normal[:, 1] *= -1
        self._weights = np.zeros((4, *height.shape))  # w / height, of each node in each triangle
        self._weights[1] = foot / (self._length * height)
        self._weights[0] = 1 / height - self._weights[1]
        self._weights[2, 0], self._weights[3, 1] = -1 / height

    @cached_property
    def angle(self) -> Array:
        """Angle across each hinge, rad, shape (...); (-pi, pi] without whole turns."""
        first, second = self._normal[:, 0], self._normal[:, 1]
        angle = np.arctan2(_dot(self._along, _cross(first, second)), _dot(first, second))
        return angle + FULL_TURN * self._turns

    @cached_property
    def gradient(self) -> Array:
        """Derivative of the angle by the nodes' positions, 1/m, shape (3, 4, ...)."""
        first, second = (self._normal[:, None, side] * self._weights[:, side] for side in range(2))
        return first + second

    def hessian_rows(self) -> tuple[Array, Array]:
        """Return rows L and R of which S[L^T R] is the second derivative, each (4, 3, 4, ...)."""
        left, right = np.zeros((2, 4, *self.gradient.shape))
        for side in range(2):
            normal, inward = self._normal[:, side], self._inward[:, side]
            weights = self._weights[:, side]
            left[side] = normal[:, None] * weights
            right[side] = inward[:, None] * weights
            add_at_ends(left[2 + side], normal)
            right[2 + side] = (-self._along / self._length)[:, None] * weights
            add_at_ends(right[2 + side], inward / (2 * self._length**2))
        return left, right


def fold_product(left: Array, right: Array) -> Array:
    """Return S[L^T R] of rows of shape (r, 3, 4, h), shape (h, 12, 12): x of the nodes, y, z."""
    rows = (side.reshape(len(side), 12, -1).transpose(2, 0, 1) for side in (left, right))
    one, other = map(np.ascontiguousarray, rows)
    half = one.transpose(0, 2, 1) @ other
    return half + half.transpose(0, 2, 1)


def add_at_ends(row: Array, vector: Array) -> None:
    """Add c (x) v to a row (3, 4, ...)."""
    row[:, 0] -= vector
    row[:, 1] += vector


def _dot(a: Array, b: Array) -> Array:
    """Product of vectors (3, ...); quicker than a sum over their first axis."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Array, b: Array) -> Array:
    """Cross product of vectors (3, ...)."""
    x, y, z = a
    u, v, w = b
    return np.stack([y * w - z * v, z * u - x * w, x * v - y * u])
