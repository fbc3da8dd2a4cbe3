"""Arruda-Boyce, the chain network of eight chains as a series of five terms.

    w = mu sum_i C_i / lm^(2 i - 2) (I1^i - 3^i),  C = 1/2, 1/20, 11/1050, 19/7000, 519/673750

The small-strain shear modulus is mu (1 + 3/(5 lm^2) + 99/(175 lm^4) + 513/(875 lm^6) +
42039/(67375 lm^8)).

Source: E. M. Arruda, M. C. Boyce, *A three-dimensional constitutive model for the large stretch
behavior of rubber elastic materials*, Journal of the Mechanics and Physics of Solids 41 (1993)
389-412; the series as in the Abaqus Theory Guide.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from bilayer.specimen.materials.hyperelastic import Hyperelastic, shear_and_d1
from bilayer.specimen.materials.law import Functions
from bilayer.validation import positive

SERIES = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
"""Of the inverse Langevin function."""


@dataclass(frozen=True)
class ArrudaBoyce(Hyperelastic):
    """Arruda-Boyce constants.

    Parameters
    ----------
    mu : float
        Modulus of the network, Pa; the small-strain shear modulus is a little more.
    lambda_m : float
        Stretch of a chain at which it locks. The series itself does not lock.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> law = bilayer.ArrudaBoyce(mu=30e3, lambda_m=3.0)
    >>> round(law.poisson_ratio, 3)
    0.5
    """

    mu: float
    lambda_m: float
    d1: float = 0.0

    name: ClassVar[str] = "arruda-boyce"
    units: ClassVar[Mapping[str, str]] = {"mu": "Pa", "lambda_m": "", "d1": "1/Pa"}
    moduli: ClassVar[Mapping[str, str]] = {
        "young_modulus": "Pa",
        "poisson_ratio": "",
        "lambda_m": "",
    }

    def _check_moduli(self) -> None:
        positive("mu", self.mu, "Pa")
        positive("lambda_m", self.lambda_m)
        super()._check_moduli()

    @classmethod
    def from_moduli(
        cls, young_modulus: float, poisson_ratio: float, lambda_m: float
    ) -> "ArrudaBoyce":
        """Return the constants of small-strain moduli and of the locking stretch."""
        shear, d1 = shear_and_d1(young_modulus, poisson_ratio)
        return cls(shear / cls(1.0, lambda_m).shear_modulus, lambda_m, d1)

    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """See `Hyperelastic`."""
        per_square = 1 / (self.lambda_m * self.lambda_m)
        total, factor, power, rest = 0.0, self.mu, I1, 3
        for coefficient in SERIES:
            total = total + coefficient * factor * (power - rest)
            factor, power, rest = factor * per_square, power * I1, rest * 3
        return total
