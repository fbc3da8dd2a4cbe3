"""BFGS update of a factor: the inverse of the stiffness nearby, from the changes of the forces.

The factor of one state is used for steps at other states, where it is not exact. A step s changes
the residual force by y. The inverse H of the stiffness there satisfies the secant condition
s = H y. BFGS (Broyden, Fletcher, Goldfarb, Shanno) takes the nearest such H that is symmetric and
positive definite. Nocedal's two loops apply it without storing it (Updating quasi-Newton matrices
with limited storage, Math. Comp. 35, 1980), with the factor in their middle. Matthies and Strang
(Int. J. Numer. Meth. Eng. 14, 1979) use it in this way for structures.
"""

import numpy as np
from numpy.typing import NDArray

from dshell.solve.linear_solver import Factor

Array = NDArray[np.float64]

LEAST_COSINE = 1e-10
"""Of the angle between a step and the change of force; what turns against a step is no news."""


class SecantInverse:
    """A factor of a positive definite matrix and what steps have shown since.

    Parameters
    ----------
    factor : Factor
        Of the stiffness where the steps began.
    """

    def __init__(self, factor: Factor) -> None:
        self._factor = factor
        self._seen: list[tuple[Array, Array, float]] = []  # s, y, s . y

    def add_pair(self, step: Array, change: Array) -> None:
        """Learn from a step, m, and the change of the residual force over it, N, each (n,)."""
        product = _dot(step, change)
        if product > LEAST_COSINE * np.linalg.norm(step) * np.linalg.norm(change):
            self._seen.append((step, change, product))

    def solve(self, right_side: Array) -> Array:
        """See `dshell.solve.linear_solver.Factor`."""
        left = right_side
        shares = []
        for step, change, product in reversed(self._seen):
            share = _dot(step, left) / product
            left = left - share * change
            shares.append(share)
        solution = self._factor.solve(left)
        for (step, change, product), share in zip(self._seen, reversed(shares), strict=True):
            solution += (share - _dot(change, solution) / product) * step
        return solution


def _dot(a: Array, b: Array) -> float:
    """Return a . b; by BLAS it would depend on where the vectors lie in memory, in its last bits.

    Where a shape wanders, those bits decide the way, and no run would repeat another.
    """
    return float((a * b).sum())
