"""The saddle-shaped load that breaks a symmetry: in balance with itself on any outline.

The acceleration (X^2 - Y^2) / L^2 on some masses has a resultant and moments, unless they are as
symmetric as a disc. An affine part taken away from it leaves none, and no force on a rigid motion.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

DEGREE_3 = np.array([[1, 1, 1], [1.8, 0.6, 0.6], [0.6, 1.8, 0.6], [0.6, 0.6, 1.8]]) / 3
"""Places in a triangle, as weights of its corners (Strang and Fix 1973)."""
DEGREE_3_SHARES = np.array([-27, 25, 25, 25]) / 48
"""Shares of its area; together they integrate polynomials of degree 3."""

ROUND_OFF = 1e-13
"""A remainder below this share of the affine part counts as zero."""


@dataclass(frozen=True, eq=False)
class SaddleLoad:
    """The shape of the load: s(X, Y) = (X^2 - Y^2) / L^2 - a - b X / L - c Y / L.

    Parameters
    ----------
    length : number, or symbol of one
        L, m.
    affine : sequence of three numbers, or symbol of them
        (a, b, c).
    """

    length: Any
    affine: Any

    @classmethod
    def on_points(cls, points: Array, masses: Array, length: float) -> "SaddleLoad":
        """Return the load that is in balance on point masses.

        Parameters
        ----------
        points : (n, 2) array of float
            Where they lie, m.
        masses : (n,) array of float
            In any unit.
        length : float
            L, m.
        """
        x, y = points.T / length
        rigid = np.column_stack([np.ones_like(x), x, y])
        weighted = masses[:, None] * rigid
        affine = np.linalg.solve(rigid.T @ weighted, weighted.T @ (x**2 - y**2))
        return cls(length, np.where(np.abs(affine) < ROUND_OFF, 0.0, affine))

    @classmethod
    def on_plate(cls, points: Array, triangles: NDArray[np.int64], length: float) -> "SaddleLoad":
        """Return the load that is in balance on a plate of one density.

        Parameters
        ----------
        points : (n, 2) array of float
            Nodes, m.
        triangles : (m, 3) array of int
            Nodes of each triangle of the plate.
        length : float
            L, m.
        """
        corners = points[triangles]
        (ux, uy), (vx, vy) = (np.subtract(corners[:, k], corners[:, 0]).T for k in (1, 2))
        areas = np.abs(ux * vy - uy * vx) / 2
        places = (DEGREE_3 @ corners).reshape(-1, 2)
        return cls.on_points(places, np.outer(areas, DEGREE_3_SHARES).ravel(), length)

    def at(self, x: Any, y: Any) -> Any:
        """Return s at a place (m), or at many, or at a symbol of one."""
        x, y = x / self.length, y / self.length
        return x**2 - y**2 - self.affine[0] - self.affine[1] * x - self.affine[2] * y
