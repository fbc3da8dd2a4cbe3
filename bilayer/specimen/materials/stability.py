"""From which stretch on a sheet of a law is no longer stable.

Two criteria, both of the energy as a function of the two stretches in the plane, the volume kept:

- *Drucker*: more strain takes more stress, so the second derivative by the logarithmic strains is
  positive definite. It is a property of the material, checked as Abaqus does along uniaxial,
  equibiaxial and planar loading.
- *Equal loads* (Kearsley 1986): under dead loads that are equal in both directions, the state of
  equal stretches is stable only if the second derivative by the stretches is positive definite.
  Beyond, the sheet stretches more in one direction than in the other; a sheet whose stretches are
  held does not, so the criterion says from where on nothing but the holding keeps them equal. For
  Mooney-Rivlin it is C01 / C10 = (1 + l^-6) / (l^2 - 3 l^-4).

Source: E. A. Kearsley, *Asymmetric stretching of a symmetrically loaded elastic sheet*,
International Journal of Solids and Structures 22 (1986) 111-119.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bilayer.specimen.materials.hyperelastic import Hyperelastic
from bilayer.specimen.materials.law import Law, Stretches

Array = NDArray[np.float64]

LOADINGS: Mapping[str, Callable[[Array], tuple[Array, Array]]] = {
    "uniaxial": lambda stretch: (stretch, stretch**-0.5),
    "equibiaxial": lambda stretch: (stretch, stretch),
    "planar": lambda stretch: (stretch, np.ones_like(stretch)),
}
"""Stretches in the plane by the largest of them; the free ones keep the volume."""
DRUCKER, EQUAL_LOADS, DEAD_LOADS = "Drucker's criterion", "equal loads", "dead loads"
LOCKING = "locking at constant volume"
LARGEST_STRETCH = 10.0
_SAMPLES = 400
_IN_PLANE = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, -1.0]])  # logarithmic strains, volume kept


@dataclass(frozen=True)
class StabilityLimits:
    """Stretches from which on a law is unstable; infinite if there is none up to 10.

    Parameters
    ----------
    equal_loads : float
        Equibiaxial stretch at which a sheet under equal dead loads bifurcates.
    drucker : mapping of str to float
        Stretch by loading, see `LOADINGS`.
    """

    equal_loads: float
    drucker: Mapping[str, float]


def stability_limits(law: Law) -> StabilityLimits:
    """Return the stretches from which on a law is unstable; a law without energy has none."""
    if not isinstance(law, Hyperelastic):
        return StabilityLimits(math.inf, dict.fromkeys(LOADINGS, math.inf))
    return StabilityLimits(
        _first_loss(law, LOADINGS["equibiaxial"], dead_load_margin),
        {name: _first_loss(law, path, drucker_margin) for name, path in LOADINGS.items()},
    )


def loss_of_stability(law: Law, stretch: Stretches) -> str:
    """Return the criterion that a sheet held at two stretches in the plane fails, "" if none."""
    if not isinstance(law, Hyperelastic):
        return ""
    x, y = np.array(stretch)[:, None]
    drucker = drucker_margin(law, x, y)[0]
    if math.isnan(drucker):
        return LOCKING
    if drucker <= 0:
        return DRUCKER
    if dead_load_margin(law, x, y)[0] <= 0:
        return EQUAL_LOADS if math.isclose(*stretch) else DEAD_LOADS
    return ""


def stability_warning(name: str, law: Law, stretches: Sequence[Stretches]) -> str:
    """Return a sentence on the stretches that are beyond the stability of a law, "" if none is.

    Parameters
    ----------
    name : str
        What the layer is called.
    law : Law
        Its law.
    stretches : sequence of (float, float)
        Principal stretches in the plane, at which the layer is held.
    """
    lost: dict[str, list[str]] = {}
    for stretch in stretches:
        criterion = loss_of_stability(law, stretch)
        if criterion:
            lost.setdefault(criterion + _limit_of(law, stretch, criterion), []).append(
                f"{stretch[0]:g}" if math.isclose(*stretch) else f"{stretch[0]:g},{stretch[1]:g}"
            )
    where = "; ".join(f"at {', '.join(found)} by {why}" for why, found in lost.items())
    return f"The law of the {name} is NOT STABLE {where}." if where else ""


def _limit_of(law: Law, stretch: Stretches, criterion: str) -> str:
    """Return from which stretch on a criterion fails, in words, if that is one number."""
    if not math.isclose(*stretch):
        return ""
    if criterion == LOCKING:
        return ""
    limits = stability_limits(law)
    limit = limits.equal_loads if criterion == EQUAL_LOADS else limits.drucker["equibiaxial"]
    return f", from {limit:.4g} on" if math.isfinite(limit) else ""


def drucker_margin(law: Hyperelastic, x: Array, y: Array) -> Array:
    """Return the least eigenvalue of the second derivative by the logarithmic strains, Pa.

    Parameters
    ----------
    law : Hyperelastic
        The law.
    x, y : (n,) array of float
        Stretches in the plane.

    Returns
    -------
    (n,) array of float
        Not a number if the law has locked.
    """
    return _least_eigenvalues(strain_slopes(law, x, y)[1])


def dead_load_margin(law: Hyperelastic, x: Array, y: Array) -> Array:
    """Return the least eigenvalue of the second derivative by the stretches, Pa.

    W_ij = (H_ij - g_i delta_ij) / (l_i l_j), of the derivatives g and H by logarithmic strains;
    see `drucker_margin` for the parameters.
    """
    slope, bend = strain_slopes(law, x, y)
    stretch = np.array([x, y])
    return _least_eigenvalues((bend - slope * np.eye(2)[:, :, None]) / (stretch[:, None] * stretch))


def _least_eigenvalues(matrices: Array) -> Array:
    """Return the least eigenvalue of symmetric matrices, (2, 2, n)."""
    (a, b), (_, c) = matrices
    return (a + c) / 2 - np.hypot((a - c) / 2, b)


def strain_slopes(law: Hyperelastic, x: Array, y: Array) -> tuple[Array, Array]:
    """Return the derivatives of the energy by two logarithmic strains, the volume kept, Pa.

    Parameters
    ----------
    law : Hyperelastic
        The law.
    x, y : (n,) array of float
        Stretches in the plane.

    Returns
    -------
    (2, n) array, (2, 2, n) array
        First and second derivatives. The first ones are Cauchy stresses of a sheet under plane
        stress.
    """
    squares = np.array([x, y, 1 / (x * y)]) ** 2
    inverses = 1 / squares
    with np.errstate(invalid="ignore"):
        energy = law.slopes(squares.sum(axis=0), inverses.sum(axis=0))
    first, second = energy.first, energy.second
    I1_e, I2_e = 2 * _IN_PLANE.T @ squares, -2 * _IN_PLANE.T @ inverses
    products = I1_e[:, None] * I1_e, I1_e[:, None] * I2_e, I2_e[:, None] * I2_e
    own = 4 * (first[0] * squares + first[1] * inverses)  # I1's and I2's own second derivatives
    bend = np.einsum("ki,kn,kj->ijn", _IN_PLANE, own, _IN_PLANE)
    bend += second[0] * products[0] + second[2] * products[2]
    bend += second[1] * (products[1] + products[1].transpose(1, 0, 2))
    return first[0] * I1_e + first[1] * I2_e, bend


def _first_loss(
    law: Hyperelastic,
    path: Callable[[Array], tuple[Array, Array]],
    margin: Callable[[Hyperelastic, Array, Array], Array],
) -> float:
    """Return the first stretch along a path at which a margin vanishes."""

    def margins(stretch: Any) -> Array:
        return margin(law, *path(stretch))

    stretches = np.geomspace(1.0, LARGEST_STRETCH, _SAMPLES)
    lost = np.flatnonzero(~(margins(stretches) > 0))
    if len(lost) == 0 or np.isnan(margins(stretches[lost[:1]])[0]):  # there the law has locked
        return math.inf
    before, after = stretches[lost[0] - 1], stretches[lost[0]]
    from scipy.optimize import brentq  # slow to load

    return float(brentq(lambda s: margins(np.array([s]))[0], before, after, xtol=1e-12))
