"""Material laws of a layer, as data: constants and the elastic moduli that they stand for.

Conventions are those of Abaqus, which the paper used: for Mooney-Rivlin

    W = C10 (I1bar - 3) + C01 (I2bar - 3) + (J - 1)^2 / D1,
    mu = 2 (C10 + C01) = E / (2 (1 + nu)),   K = 2 / D1 = E / (3 (1 - 2 nu)).

`d1 = 0` (nu = 1/2) is incompressible. How a law becomes stresses is the business of each solver.
"""

import math
from dataclasses import dataclass

from bilayer.errors import InputError
from bilayer.validation import finite, not_negative, positive


@dataclass(frozen=True)
class MooneyRivlin:
    """Mooney-Rivlin constants.

    Parameters
    ----------
    c10, c01 : float
        Constants of the first and second isochoric invariant, Pa; their sum is positive.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.
    """

    c10: float
    c01: float
    d1: float = 0.0

    def __post_init__(self) -> None:
        finite("c10", self.c10)
        finite("c01", self.c01)
        not_negative("d1", self.d1, "1/Pa")
        if self.c10 + self.c01 <= 0:
            raise InputError(
                f"c10 + c01 = {self.c10 + self.c01} Pa: expected more than 0 (it is half of mu)"
            )
        largest = 3 / self.shear_modulus
        if self.d1 > largest * (1 + 1e-12):
            raise InputError(
                f"d1 = {self.d1} 1/Pa: expected at most {largest:.6g} 1/Pa, "
                "which is a Poisson ratio of 0"
            )

    @classmethod
    def from_moduli(
        cls, young_modulus: float, poisson_ratio: float, c01_over_c10: float = 0.0
    ) -> "MooneyRivlin":
        """Constants from small-strain moduli.

        Parameters
        ----------
        young_modulus : float
            E, Pa.
        poisson_ratio : float
            nu, from 0 to 0.5.
        c01_over_c10 : float
            How mu / 2 splits into C10 + C01.
        """
        shear, bulk = _shear_and_bulk(young_modulus, poisson_ratio)
        ratio = not_negative("c01_over_c10", c01_over_c10)
        c10 = shear / 2 / (1 + ratio)
        return cls(c10=c10, c01=ratio * c10, d1=2 / bulk)

    @property
    def shear_modulus(self) -> float:
        """Small-strain shear modulus mu, Pa."""
        return 2 * (self.c10 + self.c01)

    @property
    def bulk_modulus(self) -> float:
        """Small-strain bulk modulus K, Pa; infinite where d1 = 0."""
        return 2 / self.d1 if self.d1 > 0 else math.inf

    @property
    def poisson_ratio(self) -> float:
        """Small-strain Poisson ratio."""
        ratio = self.shear_modulus * self.d1 / 2  # mu / K
        return max(0.0, (3 - 2 * ratio) / (6 + 2 * ratio))

    @property
    def young_modulus(self) -> float:
        """Small-strain Young's modulus, Pa."""
        return 2 * self.shear_modulus * (1 + self.poisson_ratio)


@dataclass(frozen=True)
class NeoHookean(MooneyRivlin):
    """Mooney-Rivlin without the second invariant: C01 = 0."""

    c01: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.c01 != 0:
            raise InputError(f"c01 = {self.c01} Pa: expected 0 for law = 'neo-hookean'")


@dataclass(frozen=True)
class LinearElastic:
    """The linear law of the paper's eqs. 8-9, a linear answer to strain plus initial strain.

    Eq. 8 prints the prestress of an equibiaxial stretch as E eps (1 - nu); Hooke's law in plane
    stress gives E eps / (1 - nu), which is what this law does (2.0 E eps against the printed
    0.5 E eps at nu = 1/2).

    Parameters
    ----------
    young_modulus : float
        E, Pa.
    poisson_ratio : float
        nu, from 0 to 0.5.
    """

    young_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        _shear_and_bulk(self.young_modulus, self.poisson_ratio)

    @property
    def shear_modulus(self) -> float:
        """Shear modulus mu, Pa."""
        return _shear_and_bulk(self.young_modulus, self.poisson_ratio)[0]

    @property
    def bulk_modulus(self) -> float:
        """Bulk modulus K, Pa; infinite where nu = 1/2."""
        return _shear_and_bulk(self.young_modulus, self.poisson_ratio)[1]


Law = MooneyRivlin | LinearElastic


def _shear_and_bulk(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    young = positive("young_modulus", young_modulus, "Pa")
    nu = finite("poisson_ratio", poisson_ratio)
    if not 0 <= nu <= 0.5:
        raise InputError(f"poisson_ratio = {poisson_ratio}: expected from 0 to 0.5")
    bulk = young / (3 * (1 - 2 * nu)) if nu < 0.5 else math.inf
    return young / (2 * (1 + nu)), bulk
