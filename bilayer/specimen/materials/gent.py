"""Gent: w = -(mu Jm / 2) log(1 - (I1 - 3) / Jm), which locks as I1 - 3 approaches Jm.

From there on neither the energy nor its derivatives are numbers: a solver that gets there takes a
shorter step.

Source: A. N. Gent, *A new constitutive relation for rubber*, Rubber Chemistry and Technology 69
(1996) 59-61.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from bilayer.specimen.materials.hyperelastic import Hyperelastic, shear_and_d1
from bilayer.specimen.materials.law import Functions
from bilayer.validation import positive


@dataclass(frozen=True)
class Gent(Hyperelastic):
    """Gent's constants.

    Parameters
    ----------
    mu : float
        Small-strain shear modulus, Pa.
    jm : float
        I1 - 3 at which the law locks.
    d1 : float
        Compressibility, 1/Pa; 0 is incompressible.

    Examples
    --------
    >>> import bilayer
    >>> bilayer.Gent(mu=30e3, jm=20.0).poisson_ratio
    0.5
    """

    mu: float
    jm: float
    d1: float = 0.0

    name: ClassVar[str] = "gent"
    units: ClassVar[Mapping[str, str]] = {"mu": "Pa", "jm": "", "d1": "1/Pa"}
    moduli: ClassVar[Mapping[str, str]] = {"young_modulus": "Pa", "poisson_ratio": "", "jm": ""}

    def _check_moduli(self) -> None:
        positive("mu", self.mu, "Pa")
        positive("jm", self.jm)
        super()._check_moduli()

    @classmethod
    def from_moduli(cls, young_modulus: float, poisson_ratio: float, jm: float) -> "Gent":
        """Return the constants of small-strain moduli and of the limit Jm."""
        shear, d1 = shear_and_d1(young_modulus, poisson_ratio)
        return cls(shear, jm, d1)

    def energy(self, I1: Any, I2: Any, functions: Functions) -> Any:
        """See `Hyperelastic`."""
        # log(x) / 2 as log(sqrt(x)), whose derivatives are no numbers either beyond the limit
        return -self.mu * self.jm * functions.log(functions.sqrt(1 - (I1 - 3) / self.jm))
