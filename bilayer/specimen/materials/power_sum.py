"""The sum of a power of the three principal stretches, as a smooth function of the invariants.

Eigenvalues have no derivatives where two of them are equal, which a sheet stretched equally in both
directions always meets. With x_i = lambda_i^2, e1 = I1, e2 = I2 and x_1 x_2 x_3 = 1, the sum of x^s
follows without them:

- s whole: Newton's identities, p_m = I1 p_(m-1) - I2 p_(m-2) + p_(m-3), exactly;
- s negative: that of the inverses, whose invariants are I2 and I1;
- else, with m - 1 < s < m, x^(s - m) is a constant, a multiple of 1 / x and partial fractions,

      x^(s - m) = c + d / x + sum_k w_k / (x + t_k),

  and with P(t) = (x_1 + t) (x_2 + t) (x_3 + t) = t^3 + t^2 I1 + t I2 + 1

      sum_i x_i^m / (x_i + t) = (t^2 p_m + t (I2 p_(m-1) - p_(m-2)) + p_(m-1)) / P(t).

x^(s - m) is an integral over such fractions with positive weights (Stieltjes). The trapezoidal rule
for it in log t has poles in geometric progression and converges exponentially; with these poles the
weights are those of least squares, accurate to better than `ACCURACY` for stretches from
1 / `LARGEST_STRETCH` to `LARGEST_STRETCH`, and slowly less beyond.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError
from bilayer.specimen.materials.jet import Jet

Array = NDArray[np.float64]

LARGEST_STRETCH = 10.0
ACCURACY = 1e-12
"""Relative error of a power in that range."""
_POLES = np.geomspace(1 / 2000, 2000, 24)  # they reach 20 times as far as the squared stretches
_SAMPLES = 400
_POWERS = [range(3), range(1, 5), range(2, 7)]
"""Of t in the sums that a moment, its first and its second derivatives consist of."""


@dataclass(frozen=True, eq=False)
class PartialFractions:
    """An approximation of x^e, -1 < e < 0.

    Parameters
    ----------
    constant, inverse : float
        c, and d of d / x.
    weights : array of float
        w of the poles.
    """

    constant: float
    inverse: float
    weights: Array

    def at(self, x: Array) -> Array:
        """Return the approximation at some x."""
        return _terms(x) @ np.concatenate([self.weights, [self.constant, self.inverse]])


@lru_cache(maxsize=64)
def partial_fractions(exponent: float) -> PartialFractions:
    """Return the partial fractions of x^exponent, -1 < exponent < 0.

    Raises
    ------
    ComputationError
        They are less accurate than `ACCURACY`.
    """
    x = _squares(np.cos(np.linspace(0, np.pi, _SAMPLES)))  # closer together toward the ends
    terms = _terms(x) * x[:, None] ** -exponent
    size = np.linalg.norm(terms, axis=0)
    found = np.linalg.lstsq(terms / size, np.ones(len(x)), rcond=1e-15)[0] / size
    fractions = PartialFractions(float(found[-2]), float(found[-1]), found[:-2])
    between = _squares(np.linspace(-1, 1, 5 * _SAMPLES))
    error = float(np.abs(fractions.at(between) * between**-exponent - 1).max())
    if error > ACCURACY:
        raise ComputationError(
            f"the power {exponent} by partial fractions: relative error {error:.1e}, "
            f"expected at most {ACCURACY:g}"
        )
    return fractions


def _squares(position: Any) -> Array:
    """Return squared stretches, evenly in their logarithm, for positions from -1 to 1."""
    squares: Array = LARGEST_STRETCH ** (2 * position)
    return squares


def _terms(x: Array) -> Array:
    return np.column_stack([1 / (x[:, None] + _POLES), np.ones_like(x), 1 / x])


def power_sum(exponent: float, I1: Any, I2: Any) -> Any:
    """Return the sum of lambda^exponent over principal stretches whose product is 1.

    Parameters
    ----------
    exponent : float
        Any real number.
    I1, I2 : float, array, Jet or UFL expression
        Invariants of C.
    """
    if exponent < 0:
        exponent, I1, I2 = -exponent, I2, I1
    s = exponent / 2
    m = math.ceil(s)
    sums = _whole_power_sums(m, I1, I2)
    if s == m:
        return sums[m]
    fractions = partial_fractions(s - m)
    zeroth, first, second = _moments_of(fractions, I1, I2)
    return (
        (second + fractions.constant) * sums[m]
        + first * (I2 * sums[m - 1] - sums[m - 2])
        + (zeroth + fractions.inverse) * sums[m - 1]
    )


def _moments_of(fractions: PartialFractions, I1: Any, I2: Any) -> list[Any]:
    """Return sum_k w_k t_k^n / P(t_k) for n = 0, 1, 2.

    P is linear in I1 and I2, so the derivatives of such sums are sums of the same kind, with higher
    powers of t and of 1 / P. Jets are made of them, which spares a jet for each fraction.
    """
    if not isinstance(I1, Jet):
        (values,) = _moments(fractions, I1, I2, [range(3)])
        return [values[n] for n in range(3)]
    values, first, second = _moments(fractions, I1.value, I2.value, _POWERS)
    return [
        Jet.composed_of(
            Jet(
                values[n],
                (-1 * first[n + 2], -1 * first[n + 1]),
                (2 * second[n + 4], 2 * second[n + 3], 2 * second[n + 2]),
            ),
            (I1, I2),
        )
        for n in range(3)
    ]


def _moments(
    fractions: PartialFractions, I1: Any, I2: Any, powers: Sequence[range]
) -> list[dict[int, Any]]:
    """Return sum_k w_k t_k^n / P(t_k)^i, i = 1, 2, ..., by n of the powers wanted of each i."""
    sums = [dict.fromkeys(wanted, 0.0) for wanted in powers]
    for weight, t in zip(map(float, fractions.weights), map(float, _POLES), strict=True):
        per_P = 1 / (t * t * I1 + t * I2 + (t**3 + 1))
        inverse = 1.0
        for moments in sums:
            inverse = inverse * per_P
            for n in moments:
                moments[n] = moments[n] + weight * t**n * inverse
    return sums


def _whole_power_sums(m: int, I1: Any, I2: Any) -> dict[int, Any]:
    """Return the sums of x^k for k from -1 to m at least."""
    sums = {-1: I2, 0: 3.0, 1: I1, 2: I1 * I1 - 2 * I2}
    for k in range(3, m + 1):
        sums[k] = I1 * sums[k - 1] - I2 * sums[k - 2] + sums[k - 3]
    return sums
