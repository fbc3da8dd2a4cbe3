"""How sharply a surface turns over an edge: the angle across it over its present length.

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

import numpy as np
from numpy.typing import NDArray

from dshell.hinges import NUMBERING, Fold

Array = NDArray[np.float64]


class Turn(Fold):
    """The angle across hinges over their present length, with its derivatives; see `Fold`."""

    def __init__(self, corners: Array, numbering: tuple[int, int, int, int] = NUMBERING) -> None:
        super().__init__(corners, numbering)
        self._ratio = self.angle / self._length

    @property
    def sharpness(self) -> Array:
        """The angle over the present length, 1/m, shape (h,)."""
        return self._ratio

    @property
    def sharpness_gradient(self) -> Array:
        """Derivative of the sharpness by the nodes' positions, 1/m2, shape (h, 4, 3)."""
        change = self.gradient
        for end, sign in zip(self._ends, (-1.0, 1.0), strict=True):
            change[:, end] -= sign * self._ratio[:, None] * self._along
        return np.divide(change, self._length[:, None, None])

    def sharpness_hessian(self, factor: Array) -> Array:
        """Return a factor (h,) times the second derivative, 1/m3, shape (h, 12, 12).

        It is H(theta) / l' - S[d(theta / l') (x) d l'] / l' - (theta / l') H(l') / l'.
        """
        share = np.divide(factor, self._length)
        hessian = self.hessian(share)
        slope = (share[:, None, None] * self.sharpness_gradient).reshape(-1, 12)
        across = np.divide(share * self._ratio, self._length)[:, None, None] * (
            np.eye(3) - self._along[:, :, None] * self._along[:, None, :]
        )
        for end, sign in zip(self._ends, (-1.0, 1.0), strict=True):
            row = slice(3 * end, 3 * end + 3)
            part = sign * slope[:, :, None] * self._along[:, None, :]
            hessian[:, :, row] -= part
            hessian[:, row, :] -= part.transpose(0, 2, 1)
            for other, its_sign in zip(self._ends, (-1.0, 1.0), strict=True):
                hessian[:, row, 3 * other : 3 * other + 3] -= sign * its_sign * across
        return hessian
