"""Yeoh: w = C10 (I1 - 3) + C20 (I1 - 3)^2 + C30 (I1 - 3)^3, mu = 2 C10.

Source: O. H. Yeoh, *Some forms of the strain energy function for rubber*, Rubber Chemistry and
Technology 66 (1993) 754-771.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from bilayer.specimen.materials.hyperelastic import Hyperelastic, shear_and_d1
from bilayer.specimen.materials.law import Functions
from bilayer.validation import finite


@dataclass(frozen=True)
class Yeoh(Hyperelastic):
    """Yeoh's constants.

    Parameters
    ----------
    c10, c20, c30 : float
        Constants of the first three powers of I1 - 3, Pa; c10 is positive.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> round(bilayer.Yeoh(c10=20e3, c20=-400.0, c30=50.0).young_modulus)
    120000
    """

    c10: float
    c20: float
    c30: float
    d1: float = 0.0

    name: ClassVar[str] = "yeoh"
    units: ClassVar[Mapping[str, str]] = {"c10": "Pa", "c20": "Pa", "c30": "Pa", "d1": "1/Pa"}
    moduli: ClassVar[Mapping[str, str]] = {
        "young_modulus": "Pa",
        "poisson_ratio": "",
        "c20_over_c10": "",
        "c30_over_c10": "",
    }

    @classmethod
    def from_moduli(
        cls,
        young_modulus: float,
        poisson_ratio: float,
        c20_over_c10: float = 0.0,
        c30_over_c10: float = 0.0,
    ) -> "Yeoh":
        """Return the constants of small-strain moduli and of the ratios C20 / C10, C30 / C10."""
        shear, d1 = shear_and_d1(young_modulus, poisson_ratio)
        second, third = finite("c20_over_c10", c20_over_c10), finite("c30_over_c10", c30_over_c10)
        c10 = shear / 2
        return cls(c10, second * c10, third * c10, d1)

    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """See `Hyperelastic`."""
        x = I1 - 3
        return x * (self.c10 + x * (self.c20 + x * self.c30))
