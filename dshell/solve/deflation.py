"""Deflation: Newton's method that does not go to equilibria that are known.

The residual is multiplied by m(x) = product over the known of 1 + (scale / distance)^2, which has
no root where they are. The step of the deflated residual is Newton's own step d times

    tau = 1 / (1 - grad m . d / m),

so no matrix changes (Farrell, Birkisson and Funke, SIAM J. Sci. Comput. 37, 2015, arXiv 1410.5620,
equation 3.4). The distance is that of two surfaces after the rigid motion that brings them nearest:
all positions of one shape are one. At that motion the distance does not change with the motion, so
its gradient is that of the distance of the points as they lie.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bilayer.geometry.alignment import align

Array = NDArray[np.float64]


class ShapeDeflation:
    """The factor of a Newton step that leads away from shapes that are known.

    Parameters
    ----------
    known : sequence of (n, 3) array of float
        The shapes, in any position and orientation, m.
    weights : (n,) array of float
        Of their points; their sum is 1.
    scale : float
        Distance below which a shape repels, m.
    """

    def __init__(self, known: Sequence[Array], weights: Array, scale: float) -> None:
        self._known, self._weights, self._scale = known, weights, scale

    def factor(self, state: Array, step: Array) -> float:
        """Return tau for a state, whose first entries are the points' coordinates, and its step."""
        change = sum(self._relative_change(shape, state, step) for shape in self._known)
        return 1.0 / (1.0 - change) if change != 1.0 else 1.0

    def value(self, state: Array) -> float:
        """Return m at a state."""
        return float(np.prod([1 + self._ratio(shape, state)[0] for shape in self._known]))

    def _ratio(self, shape: Array, state: Array) -> tuple[float, Array]:
        """Return (scale / distance)^2, and the weighted vectors from the known shape."""
        points = state[: shape.size].reshape(-1, 3)
        apart = self._weights[:, None] * (points - align(shape, points, self._weights))
        squared = float(np.sum(apart**2 / self._weights[:, None]))
        return self._scale**2 / max(squared, np.finfo(float).tiny), apart

    def _relative_change(self, shape: Array, state: Array, step: Array) -> float:
        """Return the change over a step of the logarithm of a shape's factor of m."""
        ratio, apart = self._ratio(shape, state)
        squared = self._scale**2 / ratio
        change = 2 * float(np.sum(apart * step[: shape.size].reshape(-1, 3)))
        return -ratio / (1 + ratio) * change / squared
