"""Least squares: the constants of a law with which it comes nearest to measured stresses."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.errors import ComputationError, InputError
from bilayer.fitting.laws import FITTED, Fitted
from bilayer.fitting.measurement import Measurement
from bilayer.specimen.materials.hyperelastic import Hyperelastic, shear_and_d1
from bilayer.specimen.materials.stability import LOADINGS, strain_slopes
from bilayer.validation import one_of

Array = NDArray[np.float64]
CONFIDENCE = 0.95
LIMITS: dict[str, Any] = {
    "jac": "2-point", "xtol": 1e-11, "ftol": 1e-12, "gtol": 1e-12, "max_nfev": 100,
}  # fmt: skip
"""Of `scipy.optimize.least_squares`."""
AT_BOUND = 1e-6
"""Constants that are nearer to a bound than this share of the shear modulus are at it."""


@dataclass(frozen=True)
class Constant:
    """A constant that was fitted.

    Parameters
    ----------
    name, unit : str
        As in a specimen file.
    value : float
        In SI units.
    interval : (float, float)
        Within which it lies with a confidence of 95 %; not a number if it is at a bound.
    """

    name: str
    unit: str
    value: float
    interval: tuple[float, float]


@dataclass(frozen=True)
class Fit:
    """A law that was fitted, and how well.

    Parameters
    ----------
    law_name : str
        As in `FITTED`.
    law : Hyperelastic
        With its constants.
    constants : tuple of Constant
        All of them but D1.
    measurements : tuple of Measurement
        What it was fitted to.
    weights : tuple of float
        By which the residuals of each were multiplied, 1/Pa.
    rms : float
        Root of the mean square of the residuals over the largest stress of their measurement.
    r_squared : float
        One less the squares of the residuals over those of the stresses about their mean.
    aicc : float
        Akaike's criterion with the correction for few points; differences between laws count.
    bounded : bool
        Whether bounds held the constants.
    """

    law_name: str
    law: Hyperelastic
    constants: tuple[Constant, ...]
    measurements: tuple[Measurement, ...]
    weights: tuple[float, ...]
    rms: float
    r_squared: float
    aicc: float
    bounded: bool


def nominal_stress(law: Hyperelastic, loading: str, stretch: Array) -> Array:
    """Return the nominal stress of an incompressible sheet under a loading, Pa.

    The derivative of the energy by the logarithm of the stretch, over the stretch.

    Parameters
    ----------
    law : Hyperelastic
        Its compressibility is left out.
    loading : {"uniaxial", "equibiaxial", "planar"}
        Which of the stretches in the plane are prescribed.
    stretch : ndarray, shape (n,)
        Along the loading.

    Examples
    --------
    >>> import numpy as np
    >>> from bilayer import MooneyRivlin
    >>> law = MooneyRivlin(4839.1, 14536.0)
    >>> nominal_stress(law, "uniaxial", np.array([1.06])).round(1).tolist()
    [6307.9]
    """
    x, y = LOADINGS[loading](stretch)
    slopes, _ = strain_slopes(law, x, y)
    return np.asarray(slopes[0] / stretch)


def fit(
    measurements: Sequence[Measurement],
    law: str = "mooney-rivlin",
    poisson_ratio: float = 0.5,
    bounded: bool = True,
) -> Fit:
    """Fit a law to measurements by least squares of the nominal stresses.

    Residuals are divided by the largest stress of their measurement and the root of its number of
    points, so that several measurements weigh the same. Confidence intervals come from the
    sandwich of residuals (HC3, MacKinnon and White 1985), which holds whether the noise is the
    same everywhere or grows with the stress.

    Parameters
    ----------
    measurements : sequence of Measurement
        Of one material.
    law : str
        One of `FITTED`.
    poisson_ratio : float
        Gives D1; it does not change the fit, which is of incompressible sheets.
    bounded : bool
        Whether the constants stay within bounds that keep the law stable.

    Raises
    ------
    InputError
        The law is unknown, or there are too few points.
    ComputationError
        No start leads to constants that make a law.

    Examples
    --------
    >>> import bilayer, numpy as np
    >>> stretch = np.linspace(1.0, 1.5, 11)
    >>> stress = 40e3 * (stretch - stretch**-2)  # of a neo-Hookean sheet
    >>> test = bilayer.Measurement("exact", "uniaxial", stretch, stress)
    >>> round(bilayer.fit([test], "neo-hookean").law.c10)
    20000
    """
    how = FITTED[one_of("law", law, FITTED)]
    count = sum(len(m.stretch) for m in measurements)
    if count <= len(how.names) + 1:
        raise InputError(
            f"law = {law!r}: has {len(how.names)} constants, expected at least "
            f"{len(how.names) + 2} points, there are {count}"
        )
    weights = tuple(_weight(m) for m in measurements)
    best = _best(how, measurements, weights, bounded)
    fitted = how.law(best.x, _d1(how.law(best.x, 0.0), poisson_ratio))
    squares = float(best.fun @ best.fun)
    mean_square = squares / len(
        measurements
    )  # of a measurement's residuals over its largest stress
    return Fit(
        law,
        fitted,
        _constants(how, best, count),
        tuple(measurements),
        weights,
        math.sqrt(mean_square),
        _r_squared(squares, measurements, weights),
        _aicc(mean_square, count, len(how.names)),
        bounded,
    )


def _weight(measurement: Measurement) -> float:
    largest = float(np.abs(measurement.stress).max(initial=0.0))
    if largest == 0:
        raise InputError(f"{measurement.name}: has no stress other than 0")
    return 1 / (largest * math.sqrt(len(measurement.stress)))


def _best(
    how: Fitted, measurements: Sequence[Measurement], weights: Sequence[float], bounded: bool
) -> Any:
    """Return the best of the solutions of `scipy.optimize.least_squares` from all starts."""
    from scipy.optimize import least_squares  # slow to load

    shear = _approximate_shear(measurements)
    lower = np.array(how.lower if bounded else how.needed)
    upper = np.array(how.upper)
    scale = np.array([shear if unit == "Pa" else 1.0 for unit in how.units])

    count = sum(len(m.stretch) for m in measurements)

    def residuals(values: Array) -> Array:
        try:
            law = how.law(tuple(values), 0.0)
        except InputError:  # there is no such law: far from any that fits
            return np.full(count, 1e3)
        with np.errstate(all="ignore"):
            found = [
                weight * (nominal_stress(law, m.loading, m.stretch) - m.stress)
                for m, weight in zip(measurements, weights, strict=True)
            ]
        return np.nan_to_num(np.concatenate(found), nan=1e6, posinf=1e6, neginf=-1e6)

    begins = [np.clip(start, lower + 1e-9 * scale, upper) for start in how.starts(shear)]
    solutions = [
        least_squares(residuals, begin, bounds=(lower, upper), x_scale=scale, **LIMITS)
        for begin in begins
    ]
    best = min(solutions, key=lambda solution: solution.cost)
    if best.cost > 1e3:
        raise ComputationError("no start leads to constants of the law, expected another law")
    for bound in (lower, upper):
        near = np.abs(best.x - bound) <= AT_BOUND * scale
        best.active_mask[near], best.x[near] = 1, bound[near]
    return best


def _approximate_shear(measurements: Sequence[Measurement]) -> float:
    """Return about the shear modulus, Pa: a neo-Hookean law through the largest stresses."""
    moduli = []
    for m in measurements:
        k = int(np.abs(m.stretch - 1).argmax())
        unit = nominal_stress(
            FITTED["neo-hookean"].law((0.5,), 0.0), m.loading, m.stretch[k : k + 1]
        )
        moduli.append(abs(m.stress[k] / unit[0]) if unit[0] else 1.0)
    return float(np.mean(moduli))


def _constants(how: Fitted, best: Any, count: int) -> tuple[Constant, ...]:
    from scipy.stats import t  # slow to load

    free = np.flatnonzero(best.active_mask == 0)
    error = np.full(len(how.names), math.nan)
    if len(free):
        jacobian, residual = best.jac[:, free], best.fun
        inverse = np.linalg.pinv(jacobian.T @ jacobian)
        leverage = np.einsum("ij,jk,ik->i", jacobian, inverse, jacobian)
        weighted = jacobian * (residual / np.maximum(1 - leverage, 1e-12))[:, None]
        error[free] = np.sqrt(np.maximum(np.diag(inverse @ (weighted.T @ weighted) @ inverse), 0))
    half = error * t.ppf((1 + CONFIDENCE) / 2, count - len(free))
    return tuple(
        Constant(name, unit, float(value), (float(value - h), float(value + h)))
        for name, unit, value, h in zip(how.names, how.units, best.x, half, strict=True)
    )


def _d1(law: Hyperelastic, poisson_ratio: float) -> float:
    """Return D1 of a law's shear modulus and a Poisson ratio, 1/Pa."""
    return shear_and_d1(2 * law.shear_modulus * (1 + poisson_ratio), poisson_ratio)[1]


def _r_squared(
    squares: float, measurements: Sequence[Measurement], weights: Sequence[float]
) -> float:
    """Return the coefficient of determination of weighted residuals, given their squares."""
    total = sum(
        float(np.sum((weight * (m.stress - m.stress.mean())) ** 2))
        for m, weight in zip(measurements, weights, strict=True)
    )
    return 1 - squares / total if total else math.nan


def _aicc(mean_square: float, count: int, constants: int) -> float:
    """Return Akaike's criterion of normal residuals, corrected for few points."""
    k = constants + 1  # the variance is one more
    if mean_square == 0:
        return -math.inf
    return count * math.log(mean_square) + 2 * k + 2 * k * (k + 1) / max(count - k - 1, 1)
