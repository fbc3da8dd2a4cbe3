"""The turn of a surface over an edge: the angle across the edge over its present length.

With the flat length l, the present length l' and the angle theta, Morley's rule asks for the turn
theta l / l'. The angle itself would do while the surface hardly stretches. The second fundamental
form of a face, pulled back to the flat state, is

    b = sum_i (l_i / A) a_i (h_i' / h_i)  n_i (x) n_i

since a normal that turns by a_i over edge i moves along the edge's own deformed normal, which is
F^-T n_i |F^-T n_i|^-1, and |F^-T n_i|^-1 = h_i' / h_i, the ratio of the heights over the edge. A
fibre that keeps its volume is shorter by A / A', so strain varies along it as z b A / A', and
(h_i' / h_i)(A / A') = l_i / l_i'. Without the ratio the curvature is off by as much as the surface
has stretched, and by how much depends on how the edges lie: refining the mesh does not help.
"""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from dshell.energies.hinges import Fold, add_at_ends

Array = NDArray[np.float64]


class Turn(Fold):
    """The angle across hinges over their present length, with its derivatives; see `Fold`."""

    @cached_property
    def sharpness(self) -> Array:
        """The angle over the present length, 1/m, shape (...)."""
        return self.angle / self._length

    @cached_property
    def sharpness_gradient(self) -> Array:
        """Derivative of the sharpness by the nodes' positions, 1/m2, shape (3, 4, ...)."""
        change = self.gradient.copy()
        add_at_ends(change, -self.sharpness * self._along)
        return change / self._length

    def sharpness_hessian_rows(self) -> tuple[Array, Array]:
        """Return rows L and R of which S[L^T R] is the second derivative, each (6, 3, 4, ...).

        With l = l', a the angle, t along the hinge and c (x) t the derivative of l, it is

            H(a) / l - S[da (x) (c (x) t)] / l^2 + 2 a / l^3 (c (x) t)^2 - a / l^2 H(l),

        where l H(l) is c c^T times the projection across t, which n and m of either triangle span.
        """
        length, along, sharpness = self._length, self._along, self.sharpness
        left, right = np.zeros((2, 6, *self.gradient.shape))
        left[:4], angle_part = self.hessian_rows()
        right[:4] = angle_part / length
        per_area = 1 / length**2
        normal, inward = self._normal[:, 0], self._inward[:, 0]
        for side in range(2):
            add_at_ends(right[side], -per_area * along)
        add_at_ends(right[2], -0.5 * sharpness * per_area * normal)
        add_at_ends(left[4], along)
        add_at_ends(right[4], sharpness * per_area * along)
        add_at_ends(left[5], inward)
        add_at_ends(right[5], -0.5 * sharpness * per_area * inward)
        return left, right
