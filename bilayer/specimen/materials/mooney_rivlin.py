"""Mooney-Rivlin: w = C10 (I1 - 3) + C01 (I2 - 3), mu = 2 (C10 + C01)."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from bilayer.errors import InputError
from bilayer.specimen.materials.hyperelastic import Hyperelastic, shear_and_d1
from bilayer.specimen.materials.law import Functions
from bilayer.validation import not_negative


@dataclass(frozen=True)
class MooneyRivlin(Hyperelastic):
    """Mooney-Rivlin constants.

    Parameters
    ----------
    c10, c01 : float
        Constants of the first and second isochoric invariant, Pa; their sum is positive.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> law = bilayer.MooneyRivlin(c10=4839.1, c01=14536.0)
    >>> round(law.young_modulus)
    116251
    """

    c10: float
    c01: float
    d1: float = 0.0

    name: ClassVar[str] = "mooney-rivlin"
    units: ClassVar[Mapping[str, str]] = {"c10": "Pa", "c01": "Pa", "d1": "1/Pa"}
    moduli: ClassVar[Mapping[str, str]] = {
        "young_modulus": "Pa",
        "poisson_ratio": "",
        "c01_over_c10": "",
    }

    def _check_moduli(self) -> None:
        if self.c10 + self.c01 <= 0:
            raise InputError(
                f"c10 + c01 = {self.c10 + self.c01} Pa: expected more than 0 (it is half of mu)"
            )
        super()._check_moduli()

    @classmethod
    def from_moduli(
        cls, young_modulus: float, poisson_ratio: float, c01_over_c10: float = 0.0
    ) -> "MooneyRivlin":
        """Return the constants of small-strain moduli.

        Parameters
        ----------
        young_modulus : float
            E, Pa.
        poisson_ratio : float
            nu, from 0 to 0.5.
        c01_over_c10 : float
            How mu / 2 splits into C10 + C01.
        """
        shear, d1 = shear_and_d1(young_modulus, poisson_ratio)
        ratio = not_negative("c01_over_c10", c01_over_c10)
        c10 = shear / 2 / (1 + ratio)
        return cls(c10=c10, c01=ratio * c10, d1=d1)

    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """See `Hyperelastic`."""
        return self.c10 * (I1 - 3) + self.c01 * (I2 - 3)
