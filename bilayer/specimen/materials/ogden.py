"""Ogden: w = sum_i 2 mu_i / alpha_i^2 (l1^alpha_i + l2^alpha_i + l3^alpha_i - 3), i up to 3.

l are the isochoric principal stretches; mu = sum_i mu_i. In the convention of Abaqus; Ogden's own
constants are 2 mu_i / alpha_i. With alpha = 2 and -2, mu = 2 C10 and 2 C01, it is Mooney-Rivlin.

Source: R. W. Ogden, *Large deformation isotropic elasticity*, Proceedings of the Royal Society of
London A 326 (1972) 565-584.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any, ClassVar

from bilayer.errors import InputError
from bilayer.specimen.materials.hyperelastic import Hyperelastic
from bilayer.specimen.materials.law import Functions
from bilayer.specimen.materials.moduli import plain_number
from bilayer.specimen.materials.power_sum import power_sum

LARGEST_NUMBER_OF_TERMS = 3
SMALLEST_EXPONENT, LARGEST_EXPONENT = 0.1, 20.0


@dataclass(frozen=True)
class Ogden(Hyperelastic):
    """Ogden's constants.

    Parameters
    ----------
    mu : sequence of float
        Shear moduli of one to three terms, Pa; their sum is positive.
    alpha : sequence of float
        Their exponents, as many.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Ogden(mu=(30e3, 8e3), alpha=(1.3, -2.0)).poisson_ratio
    0.5
    """

    mu: tuple[float, ...]
    alpha: tuple[float, ...]
    d1: float = 0.0

    name: ClassVar[str] = "ogden"
    units: ClassVar[Mapping[str, str]] = {"mu": "Pa", "alpha": "", "d1": "1/Pa"}
    structure: ClassVar[tuple[str, ...]] = ("alpha",)

    def _check(self, key: str) -> None:
        if key == "d1":
            super()._check(key)
            return
        object.__setattr__(self, key, _terms(key, getattr(self, key)))

    def _check_moduli(self) -> None:
        if len(self.mu) != len(self.alpha):
            raise InputError(
                f"mu has {len(self.mu)} terms, alpha {len(self.alpha)}: expected one exponent "
                "for each modulus"
            )
        for exponent in self.alpha:
            if not SMALLEST_EXPONENT <= abs(exponent) <= LARGEST_EXPONENT:
                raise InputError(
                    f"alpha = {exponent}: expected from {SMALLEST_EXPONENT:g} to "
                    f"{LARGEST_EXPONENT:g}, positive or negative"
                )
        super()._check_moduli()

    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """See `Hyperelastic`."""
        total = 0.0
        for k, exponent in enumerate(self.alpha):
            at_rest = power_sum(exponent, 3.0, 3.0)  # 3 but for the error of partial fractions
            change = power_sum(exponent, I1, I2) - at_rest
            total = total + 2 / exponent**2 * self.mu[k] * change
        return total


def _terms(field: str, values: Any) -> tuple[float, ...]:
    """Return the numbers of the terms; a single number is one term."""
    given = [values] if isinstance(values, Real) else values
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(f"{field} = {values!r}: expected a list of numbers")
    numbers = tuple(plain_number(field, value) for value in given)
    if not 1 <= len(numbers) <= LARGEST_NUMBER_OF_TERMS:
        raise InputError(
            f"{field} = {list(numbers)}: expected from 1 to {LARGEST_NUMBER_OF_TERMS} numbers"
        )
    return numbers
